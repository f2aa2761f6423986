"""One step of the integrator: the motion and, side by side in the lanes of vector registers, its derivatives."""

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.dynamics import STICKS, rates_of
from cdp_ident.model.sticking import stop

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


@part
def propagate(tangent, offset, slopes, before, stage, by_state, direct):
    """Fill in the tangents' slopes at a stage, at `tangent + offset slopes[before]`."""
    s00, s01, s02, s03 = by_state[0, 0], by_state[0, 1], by_state[0, 2], by_state[0, 3]
    s10, s11, s12, s13 = by_state[1, 0], by_state[1, 1], by_state[1, 2], by_state[1, 3]
    for i in range(tangent.shape[1]):
        t1 = tangent[0, i] + offset * slopes[before, 0, i]
        t2 = tangent[1, i] + offset * slopes[before, 1, i]
        w1 = tangent[2, i] + offset * slopes[before, 2, i]
        w2 = tangent[3, i] + offset * slopes[before, 3, i]
        slopes[stage, 0, i] = w1
        slopes[stage, 1, i] = w2
        slopes[stage, 2, i] = s00 * t1 + s01 * t2 + s02 * w1 + s03 * w2 + direct[0, i]
        slopes[stage, 3, i] = s10 * t1 + s11 * t2 + s12 * w1 + s13 * w2 + direct[1, i]
    # The states that effects bring: what they do to the rods, and their own rates.
    for k in range(4, tangent.shape[0]):
        for i in range(tangent.shape[1]):
            t = tangent[k, i] + offset * slopes[before, k, i]
            slopes[stage, 2, i] += by_state[0, k] * t
            slopes[stage, 3, i] += by_state[1, k] * t
            slopes[stage, k, i] = direct[k - 2, i]
    for r in range(4, tangent.shape[0]):
        for k in range(tangent.shape[0]):
            factor = by_state[r - 2, k]
            if factor == 0.0:
                continue
            for i in range(tangent.shape[1]):
                slopes[stage, r, i] += factor * (tangent[k, i] + offset * slopes[before, k, i])


@part
def step_with_tangents(
    state, done, share, step, time, inputs, modes, coefficients, table, values, lanes_of, constants, base, slopes,
    torque_by_state, torque_by_lane, sums, by_state, direct, at, rates, end, tangent, tangent_slopes, ended,
):  # fmt: skip
    """Make one Runge-Kutta step of a share of the grid's, from the share `done` on; row 4 of the rates is at its end.

    The rates and tangents' slopes at its beginning are in row 0 already.
    """
    h = share * step
    lanes = tangent.shape[1]
    for stage in range(1, 5):
        there = done + (0.5 * share if stage < 3 else share)
        if stage < 4:
            offset = h if stage == 3 else 0.5 * h
            for r in range(len(state)):
                at[r] = state[r] + offset * rates[stage - 1, r]
        else:
            # The rates at the end are the next step's first, and give the measurements in this one their slopes.
            for r in range(len(state)):
                end[r] = state[r] + h / 6.0 * (rates[0, r] + 2.0 * rates[1, r] + 2.0 * rates[2, r] + rates[3, r])
            for joint in range(2):
                if modes[joint] == STICKS:
                    stop(end, joint)
            copy(end, at)
        rates_of(
            at, time + there * step, input_at(inputs, there), modes, coefficients, table, values, lanes_of, constants,
            base, slopes, torque_by_state, torque_by_lane, sums, by_state, direct, rates, stage,
        )  # fmt: skip
        if lanes > 0:
            if stage < 4:
                propagate(tangent, offset, tangent_slopes, stage - 1, stage, by_state, direct)
            else:
                for r in range(len(state)):
                    for i in range(lanes):
                        ended[r, i] = tangent[r, i] + h / 6.0 * (
                            tangent_slopes[0, r, i]
                            + 2.0 * tangent_slopes[1, r, i]
                            + 2.0 * tangent_slopes[2, r, i]
                            + tangent_slopes[3, r, i]
                        )
                propagate(ended, 0.0, tangent_slopes, 3, 4, by_state, direct)


@part
def is_rough(rates, h):
    """Return whether a step is too long: the rates at its last stage and its end differ by a term of fourth order."""
    largest = 0.0
    for r in range(rates.shape[1]):
        largest = max(largest, abs(rates[4, r] - rates[3, r]))
    return h * largest > 6.0 * _ROUGH
