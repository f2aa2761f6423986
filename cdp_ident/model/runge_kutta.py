"""One step of the integrator."""

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.dynamics import STICKS, rates_of
from cdp_ident.model.sticking import stop
from cdp_ident.model.tangents import STAGES

_ROUGH = 3e-6
"""Largest error estimate of a step: see `is_rough`."""


@inlined
def copy(source, target):
    """Copy numbers; numba's assignment of slices would bring its formatting of error messages, seconds to compile."""
    for i in range(len(target)):
        target[i] = source[i]


@part
def input_at(inputs, share):
    """Return the cart's acceleration at a share of the step, from those at its beginning, middle and end."""
    return inputs[0] * (1.0 - share) * (1.0 - 2.0 * share) + share * (
        4.0 * inputs[1] * (1.0 - share) + inputs[2] * (2.0 * share - 1.0)
    )


@inlined
def step_on(
    state, done, share, step, time, inputs, modes, coefficients, table, values, lanes_of, constants, base, slopes,
    by_own, by_lane, sums, by_state, direct, at, rates, end,
):  # fmt: skip
    """Make one Runge-Kutta step of a share of the grid's, from the share `done` on; row 4 of the rates is at its end.

    The rates at its beginning are there already. Where there are lanes, what the derivatives are carried on with is
    left for each stage.
    """
    h, n = share * step, len(state)
    for stage in range(1, STAGES):
        there = done + (0.5 * share if stage < 3 else share)
        offset = h if stage == 3 else 0.5 * h
        if stage < 4:
            for r in range(n):
                at[r] = state[r] + offset * rates[stage - 1, r]
        else:
            # The rates at the end are the next step's first, and give the measurements in this one their slopes.
            for r in range(n):
                end[r] = state[r] + h / 6.0 * (rates[0, r] + 2.0 * rates[1, r] + 2.0 * rates[2, r] + rates[3, r])
            for joint in range(2):
                if modes[joint] == STICKS:
                    stop(end, joint)
            copy(end, at)
        rates_of(
            at, time + there * step, input_at(inputs, there), modes, coefficients, table, values, lanes_of, constants,
            base, slopes, by_own, by_lane, sums, by_state, direct, rates, stage,
        )  # fmt: skip


@part
def is_rough(rates, h):
    """Return whether a step is too long: the rates at its last stage and its end differ by a term of fourth order."""
    largest = 0.0
    for r in range(rates.shape[1]):
        largest = max(largest, abs(rates[4, r] - rates[3, r]))
    return is_too_rough(largest, h)


@inlined
def is_too_rough(difference, h):
    """Return whether a step is too long whose rates at its last stage and its end differ by so much at most."""
    return h * difference > 6.0 * _ROUGH


@inlined
def hermite(s, h):
    """Return the weights of both ends' values, and of both ends' slopes, at a share of a step of a length [s]."""
    square = (1.0 - s) * (1.0 - s)
    return (1.0 + 2.0 * s) * square, s * s * (3.0 - 2.0 * s), h * s * square, h * s * s * (s - 1.0)
