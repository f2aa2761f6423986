import numba
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cdp_ident.model import equations
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart, physical_coefficients
from reference import pendulum
from reference.pendulum import TABLE_2, TABLE_3
from reference.strategies import pendulums, starts


@numba.njit
def sines_and_cosines(angles):
    result = np.empty((len(angles), 2))
    for i in range(len(angles)):
        result[i, 0], result[i, 1] = equations.sine_and_cosine(angles[i])
    return result


@numba.njit
def compiled_accelerations(state, u, coefficients):
    A23, A33, a1, c1, c2, m2_l2, g = coefficients
    theta1, theta2, omega1, omega2 = state
    turned = equations.sines_and_cosines(theta1, theta2)
    return equations.accelerations(turned, omega1, omega2, u, A23, A33, a1, c1, c2, m2_l2, g)


@numba.njit
def exponential_decays(exponents):
    result = np.empty(len(exponents))
    for i in range(len(exponents)):
        result[i] = equations.exponential_decay(exponents[i])
    return result


@pytest.mark.parametrize(("range_of_angles", "limit"), [(4.0, 1e-14), (1e2, 3e-14), (1e4, 3e-12), (1e6, 3e-10)])
def test_sine_and_cosine_are_right_to_the_last_digits_that_the_angle_has(range_of_angles, limit):
    angles = np.concatenate(
        [
            np.random.default_rng(1).uniform(-range_of_angles, range_of_angles, 100_000),
            np.arange(-8, 9) * (np.pi / 4),
            np.nextafter(np.pi * np.array([-3, -1, 1, 3]), 0.0),
        ]
    )
    exact = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    assert np.abs(sines_and_cosines(angles) - exact).max() < limit


@given(angle=st.floats(-1e3, 1e3))
def test_sine_and_cosine_lie_on_the_unit_circle(angle):
    assert np.hypot(*sines_and_cosines(np.array([angle]))[0]) == pytest.approx(1.0, abs=1e-14)


def test_an_exponential_decay_is_right_to_eleven_digits():
    exponents = np.concatenate([np.linspace(0.0, 1.0, 10_001), np.linspace(1.0, 700.0, 100_001)])
    np.testing.assert_allclose(exponential_decays(exponents), np.exp(-exponents), rtol=1e-11)
    assert exponential_decays(np.array([0.0]))[0] == 1.0
    assert np.all(np.abs(exponential_decays(np.array([701.0, 1e300, np.inf]))) < 1e-303)


@given(values=pendulums(), state=starts(speed=30.0), u=st.floats(-20, 20))
@example(values=TABLE_2, state=np.array([0.0, np.pi, 0.0, 0.0]), u=0.0)
def test_accelerations_are_those_of_the_lagrangian(values, state, u):
    expected = pendulum.accelerations(values, state, u)
    computed = compiled_accelerations(state, u, physical_coefficients(values))
    # At an equilibrium both are rounding only, of torques that cancel.
    np.testing.assert_allclose(computed, expected, rtol=1e-10, atol=1e-9 * np.abs(expected).max() + 1e-12)


@given(values=pendulums(), state=starts())
def test_energy_is_that_of_the_lagrangian_over_the_inertia(values, state):
    inertia = inertia_about_cart(np.array([values[symbol] for symbol in SYMBOLS]), values["L"])
    expected = pendulum.energy(values, state) / inertia
    assert equations.energy(state, physical_coefficients(values)) == pytest.approx(expected, rel=1e-10, abs=1e-9)


def motion_by_equation_1(values, times, c32_speed):
    """Return the states (n, 4) by the paper's Eq. (1), entry by entry; C32 contains the speed number `c32_speed`."""
    m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = (values[symbol] for symbol in (*SYMBOLS, "L", "g"))

    def derivative(_, state):
        theta, speeds = state[:2], state[2:]
        s, c = np.sin(theta[0] - theta[1]), np.cos(theta[0] - theta[1])
        A = np.array([[m1 * l1**2 + J1 + (m2 + m0) * L**2, m2 * L * l2 * c], [m2 * L * l2 * c, m2 * l2**2 + J2]])
        C = np.array([[c1 + c2, m2 * L * l2 * speeds[1] * s - c2], [-m2 * L * l2 * speeds[c32_speed] * s - c2, c2]])
        gravity = np.array([(m1 * l1 + (m2 + m0) * L) * g, m2 * g * l2]) * np.sin(theta)
        return np.concatenate([speeds, np.linalg.solve(A, gravity - C @ speeds)])

    solution = solve_ivp(derivative, (0, times[-1]), TABLE_3, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-11)
    return solution.y.T


THETA1_SPEED, THETA2_SPEED = 0, 1
WITHOUT_FRICTION = TABLE_2 | {"c1": 0.0, "c2": 0.0}


@pytest.mark.parametrize(
    ("c32_speed", "kept"), [(THETA1_SPEED, True), (THETA2_SPEED, False)], ids=["mended", "printed"]
)
def test_energy_is_kept_by_equation_1_only_with_its_c32_mended(c32_speed, kept):
    energy = pendulum.energy(
        WITHOUT_FRICTION, motion_by_equation_1(WITHOUT_FRICTION, np.linspace(0, 2, 201), c32_speed)
    )
    change = np.ptp(energy) / np.ptp(pendulum.energy(WITHOUT_FRICTION, np.array([[0, 0, 0, 0], [np.pi, np.pi, 0, 0]])))
    assert change < 1e-9 if kept else change > 0.1


def test_the_mended_equation_1_is_the_equation_of_the_lagrangian():
    times = np.linspace(0, 3, 301)
    expected = pendulum.motion(TABLE_2, TABLE_3, times)
    np.testing.assert_allclose(motion_by_equation_1(TABLE_2, times, THETA1_SPEED), expected, atol=1e-7)
