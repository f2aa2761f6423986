# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulated microcontroller, and hidden effects in what its encoders show."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline
from scipy.signal import lsim

from cdp_ident.model.parameters import NOMINAL, SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.rig.decoder import Decoder, Restart
from cdp_ident.rig.emulator.configuration import parse_effects
from cdp_ident.rig.emulator.device import Device, Encoders, Readings
from cdp_ident.rig.emulator.motion import Hold, LetGo, Motion, Wait
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Hello, Sample
from reference import encoders
from reference.encoders import Turned, joint_angles
from reference.pendulum import accelerations
from reference.plant import Path


def device(rate=200.0, **options):
    return Device(BinaryCodec(), Encoders(), rate, np.random.default_rng(0), **options)


def positions(count, inner_turns=0.0):
    theta = math.pi + math.tau * inner_turns * np.arange(count)
    return np.column_stack([np.full(count, 0.02), theta, np.zeros(count)])


def decode(*frames):
    return list(Decoder(BinaryCodec()).feed(b"".join(frames)))


def test_it_greets_at_once_and_then_every_second():
    events = decode(*device().send(positions(401)))
    assert [number for number, event in enumerate(events) if isinstance(event, Hello)] == [0, 201, 402]
    assert events[0] == Hello(5000, 8000, 8000, "cdp_ident emulator 1")


def test_counters_begin_where_told_and_count_turns_and_roll_over():
    frames = device(first_count=2**31 - 2, first_time_us=2**32 - 7000).send(positions(4, 0.6 / 8000))
    samples = [event for event in decode(*frames) if isinstance(event, Sample)]
    assert [sample.inner for sample in samples] == [2**31 - 2, 2**31 - 1, 2**31 - 1, -(2**31)]
    assert [sample.time_us for sample in samples] == [4294960296, 4294965296, 3000, 8000]


def test_a_reset_starts_sequence_clock_and_counters_anew():
    rig = device(first_count=500)
    before = rig.send(positions(3, 0.1))
    rig.reset()
    after = rig.send(positions(3, 0.1))
    events = decode(*before, *after)
    assert events[4] == Hello(5000, 8000, 8000, "cdp_ident emulator 1")
    assert isinstance(events[5], Restart)
    assert events[6] == Sample(0, 0, 0, 0, 0)


def test_a_fast_clock_runs_ahead():
    (*_, last) = decode(*device(clock_error=1e-3).send(positions(1001)))
    assert isinstance(last, Sample)
    assert last.time_us == 5_005_000


def driven(codec):
    return Device(codec, Encoders(), 200.0, np.random.default_rng(0))


def test_of_several_commands_the_newest_holds_and_one_that_comes_again_is_none(codec):
    rig, frames = driven(codec), [codec.encode(CartCommand(number, 100 * number)) for number in range(4)]
    assert rig.receive(frames[0] + frames[1]) == pytest.approx(0.1)
    assert rig.receive(frames[1]) is None
    assert rig.receive(b"") is None
    assert rig.receive(frames[2] + frames[3][:5]) == pytest.approx(0.2)
    assert rig.receive(frames[3][5:]) == pytest.approx(0.3)


@given(noise=st.binary(max_size=300), place=st.integers(0, 80))
def test_a_command_behind_any_noise_is_understood_and_a_damaged_one_is_none(codec, noise, place):
    rig, frame = driven(codec), bytearray(codec.encode(CartCommand(7, -1500)))
    rig.receive(noise + codec.delimiter)
    assert rig.receive(bytes(frame)) == pytest.approx(-1.5)
    damaged = bytearray(codec.encode(CartCommand(8, 100))[:-1])
    damaged[place % len(damaged)] ^= 1
    assert rig.receive(bytes(damaged) + codec.delimiter) in (None, pytest.approx(0.1))  # a digit in lower case


PERIOD = 0.005


def parsed(content):
    inertia = inertia_about_cart(np.array([NOMINAL[symbol] for symbol in SYMBOLS]), NOMINAL["L"])
    return parse_effects(content, float(inertia), 0.4, "rig.yaml")


def states(content):
    """Return 10 s of angles, speeds and accelerations that begin when the pendulum is let go."""
    script = (Hold(1.5, 1.5, 0.5), LetGo(), Wait(100.0))
    motion = Motion(physical_coefficients(NOMINAL), script, PERIOD, parsed(content))
    return np.asarray(motion.advance(2100)[100:, 1:])


@pytest.fixture(scope="module")
def plain():
    return states({})


def readings(content, motion, piece):
    shown = Readings(physical_coefficients(NOMINAL), parsed(content), PERIOD)
    return np.concatenate([shown.of(motion[begin : begin + piece]) for begin in range(0, len(motion), piece)])


def test_an_impulse_comes_at_its_time(plain):
    pushed = states({"impulse": {"outer": {"impulse": 0.02, "time": 4.0}}})
    differ = np.flatnonzero(np.abs(plain - pushed)[:, :4].max(axis=1) > 1e-6)
    assert differ[0] * PERIOD + 0.5 == pytest.approx(4.0, abs=0.06)


def test_the_motion_with_effects_is_the_same_however_it_is_asked_for():
    content = {"impulse": {"outer": {"impulse": 0.02, "time": 1.0}}, "coulomb_friction": {"outer": {"torque": 0.002}}}
    effects = parsed(content)
    script = (Hold(1.5, 1.5, 0.5), LetGo(), Wait(100.0))
    motions = [Motion(physical_coefficients(NOMINAL), script, PERIOD, effects) for _ in range(2)]
    pieces = np.concatenate([motions[1].advance(50) for _ in range(8)])
    assert pieces == pytest.approx(motions[0].advance(400), abs=1e-6)


COMPLIANCE, HEAVY = 0.01, NOMINAL["m2"] + NOMINAL["m0"]
SAG = COMPLIANCE * HEAVY * NOMINAL["g"] / NOMINAL["L"]
SWING = SAG * NOMINAL["m2"] * NOMINAL["l2"] / (HEAVY * NOMINAL["L"])
PHASE = np.random.default_rng(0).uniform(-math.pi, math.pi)
"""Of an eccentric disc [rad]."""


def late(turned):
    """Return what an outer encoder shows that is read 12.5 ms later than the inner one."""
    times, states = turned.path.times, turned.path.states
    moved = CubicHermiteSpline(times, states[:, :2], states[:, 2:])(times - 0.0125) - states[:, :2]
    return np.diff(moved, axis=1, prepend=moved[:, :1])


DESCRIBED = {
    "an offset": ({"encoder_offset": {"outer": {"offset": 0.1}}}, [encoders.offset("outer", 0.1)]),
    "a scale": ({"encoder_scale": {"inner": {"scale": 0.02}}}, [encoders.scale("inner", 0.02)]),
    "an eccentric disc": (
        {"encoder_eccentricity": {"outer": {"sine": 0.03 * math.cos(PHASE), "cosine": 0.03 * math.sin(PHASE)}}},
        [encoders.eccentricity("outer", 0.03, PHASE)],
    ),
    "a slip": ({"encoder_slip": {"outer": {"slip": 0.2, "time": 5.0}}}, [encoders.slip("outer", 0.2, 5.0)]),
    "a delay": ({"time_offset": {"outer": {"delay": 0.0125}}}, [late]),
    "play, and an offset": (
        {"backlash": {"inner": {"gap": 0.1}}, "encoder_offset": {"inner": {"offset": 0.3}}},
        [encoders.backlash("inner", 0.05), encoders.offset("inner", 0.3)],
    ),
    "a rod that bends": ({"rod_flex": {"inner": {"sag": SAG, "swing": SWING}}}, [encoders.rod_flex(COMPLIANCE)]),
}


@pytest.mark.parametrize("piece", [2000, 7, 1])
@pytest.mark.parametrize(("content", "effects"), DESCRIBED.values(), ids=DESCRIBED)
def test_encoders_show_what_an_independent_description_says_however_it_is_asked_for(plain, content, effects, piece):
    time = PERIOD * np.arange(2001)
    from_rest = np.concatenate([[[1.5, 1.5, 0.0, 0.0]], plain[:, :4]])  # where the hand let it go
    moved = Path(time, from_rest, np.array([accelerations(NOMINAL, state, 0.0) for state in from_rest]), 0.0 * time)
    added = sum(effect(Turned(NOMINAL, moved, joint_angles(moved)))[1:] for effect in effects)
    joints = np.diff(plain[:, :2], axis=1, prepend=0.0)
    assert np.abs(added).max() > 0.01
    # A joint with play turns back between samples, further than where it is described; before the start is no motion.
    assert readings(content, plain, piece)[5:] == pytest.approx((joints + added)[5:], abs=1e-4)


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
    plain, name, values, numerator, denominator, piece
):
    time = PERIOD * np.arange(len(plain))
    fine = np.arange(50 * len(plain) - 49) * PERIOD / 50
    joint, speed = plain[:, 1] - plain[:, 0], plain[:, 3] - plain[:, 2]
    _, expected, _ = lsim((numerator, denominator), CubicHermiteSpline(time, joint, speed)(fine) - joint[0], fine)
    shown = readings({name: {"outer": values}}, plain, piece)[:, 1] - joint[0]
    assert shown[400:] == pytest.approx(expected[::50][400:], abs=5e-5)
    assert np.ptp(shown[400:] - (joint - joint[0])[400:]) > 2e-3


def test_a_joint_may_have_several_harmonics():
    harmonics = [{"sine": 0.002, "cosine": 0.0, "periods": periods} for periods in (3, 7)]
    motions = [states({"cogging_torque": {"outer": given}}) for given in (harmonics, *harmonics)]
    assert all(np.abs(motions[0] - other).max() > 1e-3 for other in motions[1:])
    effects = parsed({"cogging_torque": {"outer": harmonics}})
    assert sorted(effects.values[2::3]) == [3.0, 7.0]
