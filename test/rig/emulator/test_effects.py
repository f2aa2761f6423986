# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hidden effects in the emulated rig's motion and in what its encoders show."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.signal import lsim

from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.parameters import NOMINAL, SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.rig.emulator.effects import Readings, parse_effects
from cdp_ident.rig.emulator.motion import Motion
from cdp_ident.rig.emulator.script import Hold, LetGo, Wait
from reference.hidden_effects import backlash, flex

PERIOD = 0.005
FRICTIONLESS = NOMINAL | {"c1": 0.0, "c2": 0.0}


def parsed(content: dict[str, Any], parameters: dict[str, float] = NOMINAL) -> ActingEffects:
    inertia = inertia_about_cart(np.array([parameters[symbol] for symbol in SYMBOLS]), parameters["L"])
    return parse_effects(content, float(inertia), 0.4, "rig.yaml")


def states(content: dict[str, Any], parameters: dict[str, float] = NOMINAL) -> NDArray[np.float64]:
    """Return 10 s of angles, speeds and accelerations that begin when the pendulum is let go."""
    effects = parsed(content, parameters)
    script = (Hold(1.5, 1.5, 0.5), LetGo(), Wait(100.0))
    motion = Motion(physical_coefficients(parameters), script, PERIOD, effects)
    return np.asarray(motion.advance(2100)[100:, 1:])


def readings(content: dict[str, Any], motion: NDArray[np.float64], piece: int = 2000) -> NDArray[np.float64]:
    shown = Readings(physical_coefficients(NOMINAL), parsed(content), PERIOD)
    return np.concatenate([shown.of(motion[begin : begin + piece]) for begin in range(0, len(motion), piece)])


def test_dry_friction_brings_a_frictionless_pendulum_to_rest() -> None:
    free, braked = states({}, FRICTIONLESS), states({"coulomb_friction": {"inner": {"torque": 0.05}}}, FRICTIONLESS)
    assert np.ptp(free[-200:, 0]) > 1.0
    assert np.ptp(braked[-200:, 0]) < 0.6 * np.ptp(free[-200:, 0])


def test_a_tilted_base_moves_where_it_hangs() -> None:
    heavy = NOMINAL | {"c1": 0.5, "c2": 0.3}
    assert states({"gravity_tilt": {"base": {"tilt": 0.05}}}, heavy)[-1, :2] == pytest.approx(math.pi + 0.05, abs=2e-3)


def test_an_impulse_comes_at_its_time() -> None:
    quiet, pushed = states({}), states({"impulse": {"outer": {"impulse": 0.02, "time": 4.0}}})
    differ = np.flatnonzero(np.abs(quiet - pushed)[:, :4].max(axis=1) > 1e-6)
    assert differ[0] * PERIOD + 0.5 == pytest.approx(4.0, abs=0.06)


def test_the_motion_with_effects_is_the_same_however_it_is_asked_for() -> None:
    content = {"impulse": {"outer": {"impulse": 0.02, "time": 1.0}}, "coulomb_friction": {"outer": {"torque": 0.002}}}
    effects = parsed(content)
    script = (Hold(1.5, 1.5, 0.5), LetGo(), Wait(100.0))
    motions = [Motion(physical_coefficients(NOMINAL), script, PERIOD, effects) for _ in range(2)]
    pieces = np.concatenate([motions[1].advance(50) for _ in range(8)])
    assert pieces == pytest.approx(motions[0].advance(400), abs=1e-6)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ({}, lambda inner, outer: (inner, outer)),
        ({"encoder_offset": {"outer": {"offset": 0.1}}}, lambda inner, outer: (inner, outer + 0.1)),
        ({"encoder_scale": {"inner": {"scale": 0.02}}}, lambda inner, outer: (inner + 0.02 * (inner - math.pi), outer)),
        (
            {"encoder_eccentricity": {"outer": {"sine": 0.03, "cosine": 0.01}}},
            lambda inner, outer: (inner, outer + 0.03 * np.sin(outer) + 0.01 * np.cos(outer)),
        ),
        (
            {"encoder_slip": {"outer": {"slip": 0.2, "time": 5.0}}},
            lambda inner, outer: (inner, outer + 0.2 * (np.arange(1, 2001) * PERIOD >= 5.0)),
        ),
    ],
)
@pytest.mark.parametrize("piece", [2000, 7])
def test_encoders_show_what_their_effect_says(content: dict[str, Any], expected: Any, piece: int) -> None:
    motion = states({})
    shown = readings(content, motion, piece)
    inner, outer = expected(motion[:, 0], motion[:, 1] - motion[:, 0])
    assert shown == pytest.approx(np.stack([inner, outer], axis=1))


@pytest.mark.parametrize("piece", [2000, 7, 1])
def test_a_late_encoder_shows_the_past(piece: int) -> None:
    motion = states({})
    shown = readings({"time_offset": {"outer": {"delay": 0.0125}}}, motion, piece)
    outer = motion[:, 1] - motion[:, 0]
    time = np.arange(len(motion)) * PERIOD
    before = CubicHermiteSpline(time, outer, motion[:, 3] - motion[:, 2])(time[200:] - 0.0125)
    assert shown[200:, 1] == pytest.approx(before, abs=1e-9)
    assert np.abs(shown[200:, 1] - outer[200:]).max() > 0.05


@pytest.mark.parametrize("piece", [2000, 7, 1])
def test_an_encoder_with_play_stays_behind_by_half_of_the_gap(piece: int) -> None:
    motion = states({})
    shown = readings({"backlash": {"inner": {"gap": 0.1}}, "encoder_offset": {"inner": {"offset": 0.3}}}, motion, piece)
    from_rest = np.concatenate([[[1.5] * motion.shape[1]], motion])  # where the hand let it go
    described = backlash("inner").reading(np.arange(2001) * PERIOD, lambda times: from_rest, NOMINAL, 0.05)[1:, 0]
    between_samples = 1e-4  # the joint turns back there, further than where it is described
    assert shown[:, 0] == pytest.approx(motion[:, 0] + described + 0.3, abs=between_samples)
    assert np.abs(described).max() == pytest.approx(0.05)
    assert shown[:, 1] == pytest.approx(motion[:, 1] - motion[:, 0])


@pytest.mark.parametrize("piece", [2000, 7])
def test_encoders_of_a_rod_that_bends_are_askew_by_what_an_independent_description_says(piece: int) -> None:
    compliance, heavy = 0.01, NOMINAL["m2"] + NOMINAL["m0"]
    sag = compliance * heavy * NOMINAL["g"] / NOMINAL["L"]
    swing = sag * NOMINAL["m2"] * NOMINAL["l2"] / (heavy * NOMINAL["L"])
    motion = states({})
    shown = readings({"rod_flex": {"inner": {"sag": sag, "swing": swing}}}, motion, piece)
    bent = flex().reading(np.arange(2000) * PERIOD, lambda times: motion[:, :4], NOMINAL, compliance)
    assert np.abs(bent).max() > 0.01
    inner, outer = motion[:, 0], motion[:, 1] - motion[:, 0]
    assert shown == pytest.approx(np.stack([inner, outer], axis=1) + bent, abs=1e-9)


@pytest.mark.parametrize("piece", [1, 256])
@pytest.mark.parametrize(
    ("name", "values", "numerator", "denominator"),
    [
        ("encoder_filter", {"variant": "first order", "time_constant": 0.006}, [1.0], [0.006, 1.0]),
        ("encoder_compliance", {"variant": "oscillating", "compliance": 1e-4, "damping_ratio": 0.2},
         [4e-3, 1.0], [1e-4, 4e-3, 1.0]),
    ],
)  # fmt: skip
def test_an_encoder_with_a_state_of_its_own_shows_what_its_transfer_function_says(
    name: str, values: dict[str, Any], numerator: list[float], denominator: list[float], piece: int
) -> None:
    motion = states({})
    time = PERIOD * np.arange(len(motion))
    fine = np.arange(50 * len(motion) - 49) * PERIOD / 50
    joint, speed = motion[:, 1] - motion[:, 0], motion[:, 3] - motion[:, 2]
    _, expected, _ = lsim((numerator, denominator), CubicHermiteSpline(time, joint, speed)(fine) - joint[0], fine)
    shown = readings({name: {"outer": values}}, motion, piece)[:, 1] - joint[0]
    assert shown[400:] == pytest.approx(expected[::50][400:], abs=5e-5)
    assert np.ptp(shown[400:] - (joint - joint[0])[400:]) > 2e-3


def test_the_inner_encoder_may_be_the_late_one() -> None:
    motion = states({})
    late = parsed({"time_offset": {"outer": {"delay": 0.01}}})
    late = replace(late, effects=(replace(late.effects[0], joint="inner"),))
    shown = Readings(physical_coefficients(NOMINAL), late, PERIOD).of(motion)
    assert shown[2:, 0] == pytest.approx(motion[:-2, 0], abs=1e-9)
    assert shown[:, 1] == pytest.approx(motion[:, 1] - motion[:, 0])


def test_a_joint_may_have_several_harmonics() -> None:
    harmonics = [{"sine": 0.002, "cosine": 0.0, "periods": periods} for periods in (3, 7)]
    motions = [states({"cogging_torque": {"outer": given}}) for given in (harmonics, *harmonics)]
    assert all(np.abs(motions[0] - other).max() > 1e-3 for other in motions[1:])
    effects = parsed({"cogging_torque": {"outer": harmonics}})
    assert sorted(effects.values[2::3]) == [3.0, 7.0]
