r"""The equations of motion, stated once, for every simulation in the package.

The paper's Eq. (1) for the two rods, divided by A22, with angles theta from upright, angular velocities omega, the
cart's acceleration u, and s, c the sine and cosine of theta1 - theta2::

    omega1' +  A23 c omega2' = a1 (g sin theta1 - u cos theta1) - A23 s omega2^2 - c1 omega1 - c2 (omega1 - omega2)
    A23 c omega1' + A33 omega2' = m2 l2 (g sin theta2 - u cos theta2) + A23 s omega1^2 + c2 (omega1 - omega2)

Eq. (1) prints theta2' in C32; it must be theta1': only so is energy kept without friction (docs/explanation/paper.md).

The functions here are of scalars and are compiled into loops over time and over the lanes of a vector register, which
is why they call nothing from outside.
"""

import math

import numpy as np

from cdp_ident.model.compilation import inlined

RODS_STATES = 4
"""Size of the rods' state: theta1, theta2 [rad], omega1, omega2 [rad/s]."""
_TURN_HIGH = 2.0 * math.pi
_TURN_LOW = 2.4492935982947064e-16
"""2 pi = _TURN_HIGH + _TURN_LOW to twice the precision of a double."""


@inlined
def sine_and_cosine(angle):
    """Return sine and cosine of an angle [rad], to 1e-14 within a turn, without a branch or a call.

    The angle is brought into one turn about zero, a quarter of it goes into the Taylor series, and two doublings
    bring it back.
    """
    turns = np.floor(angle * (1.0 / _TURN_HIGH) + 0.5)
    quarter = ((angle - turns * _TURN_HIGH) - turns * _TURN_LOW) * 0.25
    # Neighbouring terms first (Estrin's scheme): they need not wait for each other.
    q = quarter * quarter
    q2 = q * q
    q4 = q2 * q2
    sine = quarter * (
        ((1.0 - q * (1.0 / 6)) + q2 * (1.0 / 120 - q * (1.0 / 5040)))
        + q4 * ((1.0 / 362880 - q * (1.0 / 39916800)) + q2 * (1.0 / 6227020800.0 - q * (1.0 / 1307674368000.0)))
    )
    cosine = ((1.0 - q * (1.0 / 2)) + q2 * (1.0 / 24 - q * (1.0 / 720))) + q4 * (
        (1.0 / 40320 - q * (1.0 / 3628800)) + q2 * (1.0 / 479001600 - q * (1.0 / 87178291200.0))
    )
    half_sine, half_cosine = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine
    return 2.0 * half_sine * half_cosine, 1.0 - 2.0 * half_sine * half_sine


@inlined
def exponential_decay(x):
    """Return exp(-x) for x >= 0, to 1e-11 of itself, without a branch or a call; 1e-304 where that is less.

    A 1024th of x goes into the Taylor series, and ten squarings bring it back.
    """
    y = -min(x, 700.0) * (1.0 / 1024)
    y2 = y * y
    y4 = y2 * y2
    low = ((1.0 + y) + y2 * (1.0 / 2 + y * (1.0 / 6))) + y4 * (
        (1.0 / 24 + y * (1.0 / 120)) + y2 * (1.0 / 720 + y * (1.0 / 5040))
    )
    high = ((1.0 / 40320 + y * (1.0 / 362880)) + y2 * (1.0 / 3628800 + y * (1.0 / 39916800))) + y4 * (
        (1.0 / 479001600 + y * (1.0 / 6227020800.0)) + y2 * (1.0 / 87178291200.0)
    )
    power = low + y4 * y4 * high
    for _ in range(10):
        power = power * power
    return power


@inlined
def sines_and_cosines(theta1, theta2):
    """Return sine and cosine of theta1, and of theta2."""
    sin1, cos1 = sine_and_cosine(theta1)
    sin2, cos2 = sine_and_cosine(theta2)
    return sin1, cos1, sin2, cos2


@inlined
def torques_on_rods(turned, omega1, omega2, u, A23, a1, c1, c2, m2_l2, g, extra1, extra2):
    """Return what turns the rods over A22, the right-hand sides of the equations above, with extra torques."""
    sin1, cos1, sin2, cos2 = turned
    s = sin1 * cos2 - cos1 * sin2
    joint_friction = c2 * (omega1 - omega2)
    return (
        a1 * (g * sin1 - u * cos1) - A23 * s * omega2 * omega2 - c1 * omega1 - joint_friction + extra1,
        m2_l2 * (g * sin2 - u * cos2) + A23 * s * omega1 * omega1 + joint_friction + extra2,
    )


@inlined
def inertia_between(turned, A23, coupled):
    """Return what is beside the diagonal of the inertia matrix, over A22."""
    sin1, cos1, sin2, cos2 = turned
    return A23 * (cos1 * cos2 + sin1 * sin2) + coupled


@inlined
def accelerations(turned, omega1, omega2, u, A23, A33, a1, c1, c2, m2_l2, g, extra1=0.0, extra2=0.0, coupled=0.0):
    """Return omega1', omega2' [rad/s^2] by the equations of motion above.

    What the rods are turned by is given as `sines_and_cosines`. A23 to g are the `COEFFICIENTS`, each relative to A22;
    extra1 and extra2 are the generalised torques of effects that the paper's model lacks, and coupled what adds to the
    inertia between the rods, relative to A22 too.
    """
    n1, n2 = torques_on_rods(turned, omega1, omega2, u, A23, a1, c1, c2, m2_l2, g, extra1, extra2)
    return solved(response(A33, inertia_between(turned, A23, coupled)), n1, n2)


@inlined
def acceleration_derivatives(
    turned, omega1, omega2, u, A23, A33, a1, c1, c2, m2_l2, g, extra1, extra2, coupled=0.0, inner_sticks=False,
    outer_sticks=False,
):  # fmt: skip
    """Return omega1', omega2', the response to torques, and the accelerations' derivatives.

    The response is as `response` returns it. Then come four pairs, omega1' and omega2' by theta1, theta2, omega1,
    omega2, and seven by the coefficients A23 to g, all at constant extra torques. The equations are M omega' = N, where
    M has 1 and A33 on its diagonal and m = A23 c + coupled beside it; a derivative solves M d(omega') = dN - dM omega'.
    What holds a joint that sticks is in neither, for it follows.
    """
    sin1, cos1, sin2, cos2 = turned
    s, c = sin1 * cos2 - cos1 * sin2, cos1 * cos2 + sin1 * sin2
    by_torques = response(A33, A23 * c + coupled, inner_sticks, outer_sticks)
    i11, i12, i21, i22 = by_torques
    relative = omega1 - omega2
    push1, push2 = g * sin1 - u * cos1, g * sin2 - u * cos2
    n1, n2 = torques_on_rods(turned, omega1, omega2, u, A23, a1, c1, c2, m2_l2, g, extra1, extra2)
    alpha1, alpha2 = i11 * n1 + i12 * n2, i21 * n1 + i22 * n2
    # By theta1, dm = -A23 s, by theta2, dm = A23 s; by A23, dm = c; by A33, dM has one element, 1.
    inner, outer = A23 * c * omega2 * omega2 - A23 * s * alpha2, A23 * c * omega1 * omega1 + A23 * s * alpha1
    by_state = (
        solved(by_torques, a1 * (g * cos1 + u * sin1) - inner, outer),
        solved(by_torques, inner, m2_l2 * (g * cos2 + u * sin2) - outer),
        solved(by_torques, -c1 - c2, 2.0 * A23 * s * omega1 + c2),
        solved(by_torques, c2 - 2.0 * A23 * s * omega2, -c2),
    )
    by_coefficient = (
        solved(by_torques, -s * omega2 * omega2 - c * alpha2, s * omega1 * omega1 - c * alpha1),
        (-i12 * alpha2, -i22 * alpha2),
        (i11 * push1, i21 * push1),
        (-i11 * omega1, -i21 * omega1),
        ((i12 - i11) * relative, (i22 - i21) * relative),
        (i12 * push2, i22 * push2),
        solved(by_torques, a1 * sin1, m2_l2 * sin2),
    )
    return alpha1, alpha2, by_torques, by_state, by_coefficient


@inlined
def response(A33, m, inner_sticks=False, outer_sticks=False):
    """Return the rods' accelerations by torques on them: omega1' by one on either rod, then omega2'.

    It is the inverse of the inertia matrix, of 1, A33 and m beside its diagonal. Where a joint sticks, the torque in it
    lets no other motion be: with the inner joint the outer rod turns alone, with the outer one both rods turn as one.
    """
    inverse_determinant = 1.0 / (A33 - m * m)
    free = not (inner_sticks or outer_sticks)
    as_one = 1.0 / (1.0 + A33 + 2.0 * m) if outer_sticks and not inner_sticks else 0.0
    alone = 1.0 / A33 if inner_sticks and not outer_sticks else as_one
    return (
        A33 * inverse_determinant if free else as_one,
        -m * inverse_determinant if free else as_one,
        -m * inverse_determinant if free else as_one,
        inverse_determinant if free else alone,
    )


@inlined
def holding(n1, n2, A33, m, inner_sticks, outer_sticks):
    """Return the torques in both joints that hold those that stick, over A22; zero in one that does not."""
    of_outer = ((A33 + m) * n1 - (1.0 + m) * n2) / (1.0 + A33 + 2.0 * m)
    held2 = (-n2 if inner_sticks else of_outer) if outer_sticks else 0.0
    held1 = (-n1 - n2 if outer_sticks else m / A33 * n2 - n1) if inner_sticks else 0.0
    return held1, held2


@inlined
def solved(by_torques, n1, n2):
    """Return what two torques are of the rods' accelerations, by the response to them."""
    i11, i12, i21, i22 = by_torques
    return i11 * n1 + i12 * n2, i21 * n1 + i22 * n2


@inlined
def runge_kutta_step(theta1, theta2, omega1, omega2, step, u0, u1, u2, A23, A33, a1, c1, c2, m2_l2, g):
    """Return the state after one step of the classical Runge-Kutta method of fourth order.

    u0, u1, u2 are the cart's accelerations at the beginning, the middle and the end of the step.
    """
    half = 0.5 * step
    turned = sines_and_cosines(theta1, theta2)
    k1, j1 = accelerations(turned, omega1, omega2, u0, A23, A33, a1, c1, c2, m2_l2, g)
    p1, q1 = omega1 + half * k1, omega2 + half * j1
    turned = sines_and_cosines(theta1 + half * omega1, theta2 + half * omega2)
    k2, j2 = accelerations(turned, p1, q1, u1, A23, A33, a1, c1, c2, m2_l2, g)
    p2, q2 = omega1 + half * k2, omega2 + half * j2
    turned = sines_and_cosines(theta1 + half * p1, theta2 + half * q1)
    k3, j3 = accelerations(turned, p2, q2, u1, A23, A33, a1, c1, c2, m2_l2, g)
    p3, q3 = omega1 + step * k3, omega2 + step * j3
    turned = sines_and_cosines(theta1 + step * p2, theta2 + step * q2)
    k4, j4 = accelerations(turned, p3, q3, u2, A23, A33, a1, c1, c2, m2_l2, g)
    sixth = step / 6.0
    return (
        theta1 + sixth * (omega1 + 2.0 * p1 + 2.0 * p2 + p3),
        theta2 + sixth * (omega2 + 2.0 * q1 + 2.0 * q2 + q3),
        omega1 + sixth * (k1 + 2.0 * k2 + 2.0 * k3 + k4),
        omega2 + sixth * (j1 + 2.0 * j2 + 2.0 * j3 + j4),
    )


def energy(state, coefficients):
    """Return the mechanical energy over A22 [1/s^2] of states (..., 4): theta1, theta2, omega1, omega2.

    Without friction and with the cart at rest it stays constant; with friction it never grows.
    """
    theta1, theta2, omega1, omega2 = np.moveaxis(np.asarray(state, dtype=float), -1, 0)
    A23, A33, a1, _, _, m2_l2, g = np.moveaxis(np.asarray(coefficients, dtype=float), -1, 0)
    kinetic = 0.5 * omega1**2 + 0.5 * A33 * omega2**2 + A23 * np.cos(theta1 - theta2) * omega1 * omega2
    return kinetic + g * (a1 * np.cos(theta1) + m2_l2 * np.cos(theta2))
