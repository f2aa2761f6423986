"""When joints with dry friction stop, stick and break loose, and what that does to derivatives (compiled).

A step of the integrator ends where a joint's speed passes through zero, or where the torque that holds a sticking
joint reaches its friction. There the rate of change may jump by what friction does: derivatives of the motion are
carried across by the saltation matrix (Leine and Nijmeijer, Dynamics and Bifurcations of Non-smooth Mechanical
Systems, 2004, chapter 7; Hiskens and Pai, IEEE Trans. Circuits and Systems I 47, 2000).
"""

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.dynamics import COUPLING, HOLDS, SIZES, STICKS, joint_speed, rates_at
from cdp_ident.model.equations import inertia_between, sines_and_cosines
from cdp_ident.model.tangents import OLD, blocks_of, row_of, width_of


@part
def stop(state, joint):
    """Set a joint's speed to exactly zero."""
    if joint == 0:
        state[2] = 0.0
    else:
        state[3] = state[2]


@part
def settle(
    state, time, u, modes, dry, loose, coefficients, table, values, lanes_of, constants, base, slopes, by_own,
    by_lane, sums, by_state, direct, rates, row,
):  # fmt: skip
    """Decide which of the joints at rest stick and where the others go; the rates are those after that.

    Args:
        state: (n,) the state.
        time: time in the trial [s].
        u: the cart's acceleration [m/s^2].
        modes: (2,) takes the joints' modes.
        dry: (2,) which joints have dry friction.
        loose: the joint that has just broken loose, whose holding torque is in `sums`; -1 for none.
        coefficients: as `rates_of` takes them, like all that follow.
        table: likewise.
        values: likewise.
        lanes_of: likewise.
        constants: likewise.
        base: likewise.
        slopes: likewise.
        by_own: likewise.
        by_lane: likewise.
        sums: likewise.
        by_state: likewise.
        direct: likewise.
        rates: likewise.
        row: likewise.
    """
    for joint in range(2):
        if dry[joint]:
            speed = joint_speed(state, joint)
            modes[joint] = 1 if speed > 0.0 else (-1 if speed < 0.0 else STICKS)
    if loose >= 0:
        # It moves against the torque that held it.
        modes[loose] = -1 if sums[HOLDS + loose] > 0.0 else 1
    # The modes of two joints at rest depend on each other: all combinations are tried until one is consistent.
    given_inner, given_outer = modes[0], modes[1]
    best, best_inner, best_outer = 1e300, given_inner, given_outer
    for attempt in range(10):
        inner, outer = attempt // 3, attempt % 3
        if attempt == 9:
            modes[0], modes[1] = best_inner, best_outer
        elif (given_inner != STICKS and inner > 0) or (given_outer != STICKS and outer > 0):
            continue
        else:
            modes[0] = (-1 if inner == 2 else inner) if given_inner == STICKS else given_inner
            modes[1] = (-1 if outer == 2 else outer) if given_outer == STICKS else given_outer
        rates_at(
            state, time, u, modes, coefficients, table, values, lanes_of, constants, base, slopes, by_own,
            by_lane, sums, by_state, direct, rates, row,
        )  # fmt: skip
        wrong = 0.0
        if given_inner == STICKS:
            excess = violation(state, 0, modes, sums) if modes[0] == STICKS else -float(modes[0]) * rates[row, 2]
            wrong += max(excess, 0.0)
        if given_outer == STICKS:
            onward = rates[row, 3] - rates[row, 2]
            excess = violation(state, 1, modes, sums) if modes[1] == STICKS else -float(modes[1]) * onward
            wrong += max(excess, 0.0)
        if wrong == 0.0:
            return
        if wrong < best:
            best, best_inner, best_outer = wrong, modes[0], modes[1]


@inlined
def violation(state, joint, modes, sums):
    """Return by how much a joint violates the condition of its mode: above zero, the mode has ended."""
    if modes[joint] == STICKS:
        return abs(sums[HOLDS + joint]) - max(sums[SIZES + joint], 0.0)
    return -float(modes[joint]) * joint_speed(state, joint)


@inlined
def dip(joint, modes, rates):
    """Return where in a step a slipping joint is slowest, as a share, if it slows down and speeds up again; else 0.

    `rates` has the step's beginning in row 0 and its end in row 4.
    """
    first, last = (rates[0, 2], rates[4, 2]) if joint == 0 else (rates[0, 3] - rates[0, 2], rates[4, 3] - rates[4, 2])
    mode = float(modes[joint])
    return first / (first - last) if mode * first < 0.0 and mode * last > 0.0 else 0.0


@inlined
def lateness(speed1, speed2, joint, towards):
    """Return by how much later a joint's speed is zero, by the derivatives of both rods' speeds."""
    return -(speed1 if joint == 0 else speed2 - speed1) / towards


@inlined
def held_speeds(speed1, speed2, joint, A33, m):
    """Return derivatives of both rods' speeds as a sticking joint allows them, by an impulse in it."""
    if joint == 0:
        return 0.0, speed2 + m / A33 * speed1
    common = ((1.0 + m) * speed1 + (A33 + m) * speed2) / (1.0 + A33 + 2.0 * m)
    return common, common


@inlined
def inertia_of_both(state, coefficients, table, values):
    """Return what is beside the diagonal of the inertia matrix in a state, over A22."""
    coupled = 0.0
    for e in range(len(table)):
        if table[e, 1] == COUPLING:
            coupled += values[e, 0]
    return inertia_between(sines_and_cosines(state[0], state[1]), coefficients[0], coupled)


@part
def carry_across(tangents, lanes, joint, before, after):
    """Carry derivatives across the instant at which a joint's speed is zero.

    Args:
        tangents: derivatives of the state, in so many lanes.
        lanes: so many.
        joint: 0 inner, 1 outer.
        before: (n,) rates of change before.
        after: (…, n) rates of change after, in row 0.
    """
    towards = before[2] if joint == 0 else before[3] - before[2]
    if towards == 0.0:
        return
    n = len(before)
    for block in range(blocks_of(lanes)):
        omega1, omega2 = row_of(n, block, 2, OLD), row_of(n, block, 3, OLD)
        for i in range(width_of(block, lanes)):
            late = lateness(tangents[omega1 + i], tangents[omega2 + i], joint, towards)
            for r in range(2, n):
                tangents[row_of(n, block, r, OLD) + i] += (before[r] - after[0, r]) * late


@part
def hold(tangents, states, lanes, joint, A33, m):
    """Project derivatives on motions that a sticking joint allows, by an impulse in it that keeps its speed at zero."""
    for block in range(blocks_of(lanes)):
        omega1, omega2 = row_of(states, block, 2, OLD), row_of(states, block, 3, OLD)
        for i in range(width_of(block, lanes)):
            tangents[omega1 + i], tangents[omega2 + i] = held_speeds(
                tangents[omega1 + i], tangents[omega2 + i], joint, A33, m
            )
