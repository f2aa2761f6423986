# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model beside a rig that is held, let go, caught and pushed."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.errors import CdpIdentError
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.replay.scene import Frame
from cdp_ident.replay.shadow import Phase, Shadow
from cdp_ident.rig.emulator.motion import Hold, LetGo, Motion, MoveCart, Wait
from cdp_ident.rig.recording.facts import Position
from cdp_ident.trial.options import TrialOptions
from reference.pendulum import TABLE_5
from scenarios.driven import FRICTION, START, driven_by_motors

PERIOD = 0.005
BEGIN = 1_700_000_000_000_000_000
TRUE, WRONG = fitted_model(NOMINAL, "test"), fitted_model(NOMINAL | {"c1": 0.02}, "test")
DRIVEN = fitted_model(TABLE_5 | {"effects.quadratic_friction.outer.coefficient": FRICTION}, "test")
RELEASE = (Wait(0.5), Hold(1.8, 1.6, within=0.5), Wait(0.7), LetGo())


class Seen(NamedTuple):
    """What came of one position of the rig."""

    position: Position
    frames: list[tuple[int, Frame]]
    phase: Phase
    why: str


def fit_initial_states(shadow, *script, hanging=False):
    """Let a shadow follow a rig; one that is `hanging` counts absolute angles from there."""
    motion, seen = Motion(TRUE.coefficients, script, PERIOD), []
    while not motion.finished:
        cart, theta1, theta2, *_ = motion.advance(1)[0].tolist()
        inner, outer = (theta1 - np.pi, theta2 - np.pi) if hanging else (theta1, theta2 - theta1)
        position = Position(BEGIN + round(len(seen) * PERIOD * 1e9), inner, outer, cart)
        frames = shadow.take(position)
        seen.append(Seen(position, frames, shadow.phase, shadow.why))
    return seen


def errors(seen):
    return {stamp: max(map(abs, frame.error)) for one in seen for stamp, frame in one.frames if frame.error is not None}


def test_the_right_model_stays_beside_the_rig_from_the_release_on():
    seen = fit_initial_states(Shadow(TRUE), *RELEASE, Wait(4.0))
    phases = [one.phase for one in seen]
    assert list(dict.fromkeys(phases)) == [Phase.WAITING, Phase.LOOKING, Phase.BESIDE]
    found = errors(seen)
    assert max(found.values()) < 1e-3
    released = phases.index(Phase.LOOKING)
    assert list(found) == [one.position.stamp_ns for one in seen[released:]]  # from the first free sample, without gap
    assert phases.index(Phase.BESIDE) == pytest.approx(released + 100, abs=1)


def test_the_difference_of_a_wrong_model_grows():
    found = list(errors(fit_initial_states(Shadow(WRONG), *RELEASE, Wait(4.0))).values())
    assert max(found) > 5 * max(found[:100])


def test_another_model_is_beside_the_rig_at_once_and_has_its_own_start():
    rig, shadow, change = fit_initial_states(Shadow(TRUE), *RELEASE, Wait(4.0)), Shadow(WRONG), BEGIN + 5_000_000_000
    before = []
    after = []
    for position in (one.position for one in rig):
        if position.stamp_ns == change:
            shadow.take_model(TRUE)
        shown = [max(map(abs, frame.error)) for _, frame in shadow.take(position) if frame.error is not None]
        (before if position.stamp_ns < change else after).extend(shown)
    assert before[-1] > 0.02
    assert max(after) < 1e-3


@pytest.mark.parametrize(
    ("script", "why"),
    [
        ((Wait(2.0), Hold(2.0, 2.0, within=0.6), Wait(1.0)), "the pendulum was caught"),
        ((Wait(2.0), MoveCart(0.1), Wait(1.0)), "the cart moved by more than 0.01 m"),
    ],
)
def test_it_ends_when_the_pendulum_is_no_longer_left_to_itself_and_follows_the_next_release(script, why):
    seen = fit_initial_states(Shadow(TRUE, TrialOptions(input="none")), *RELEASE, *script, *RELEASE, Wait(2.0))
    ended = [one.why for before, one in pairwise(seen) if one.phase is Phase.WAITING is not before.phase]
    assert ended[0] == why
    assert seen[-1].phase is Phase.BESIDE
    assert max(errors(seen[-200:]).values()) < 1e-3


@pytest.mark.parametrize("input_", ["auto", "cart"])
def test_a_cart_that_is_driven_is_an_input(input_):
    drive = (MoveCart(0.15, within=0.4), Wait(0.3), MoveCart(-0.1, within=0.5), Wait(0.5))
    seen = fit_initial_states(Shadow(TRUE, TrialOptions(input=input_)), *RELEASE, Wait(2.0), *drive)
    assert seen[-1].phase is Phase.BESIDE
    assert max(errors(seen).values()) < 2e-3
    hanging = fit_initial_states(Shadow(TRUE, TrialOptions(input=input_)), Wait(2.0), *drive, *drive)
    assert bool(errors(hanging)) == (input_ == "cart")
    assert max(errors(hanging).values(), default=0.0) < 2e-3


def test_motors_in_the_joints_are_an_input_where_they_are_said_to_drive():
    rig = driven_by_motors(1)
    torques, shown = np.array(rig.torques), {}
    for joints in (True, False):
        shadow = Shadow(DRIVEN, TrialOptions(input="joints" if joints else "auto"))
        hold = [(-k, START[:2], (0.0, 0.0)) for k in range(200, 0, -1)]
        rows = hold + [(k, rig.theta[k], torques[k]) for k in range(800)]
        frames = [
            shadow.take(Position(BEGIN + k * 5_000_000, theta[0], theta[1] - theta[0], 0.0, tuple(torque)))
            for k, theta, torque in rows
        ]
        shown[joints] = max(abs(error) for of in frames for _, frame in of for error in frame.error or ())
    assert shown[True] < 0.02 < shown[False]
    shadow = Shadow(DRIVEN, TrialOptions(input="joints"))
    assert shadow.take(Position(BEGIN, *START[:2], 0.0)) == []
    assert "no efforts" in shadow.why


def test_it_ends_when_the_pendulum_rests():
    damped = fitted_model(NOMINAL | {"c1": 0.2, "c2": 0.05}, "test")
    shadow, motion = Shadow(damped), Motion(damped.coefficients, (*RELEASE, Wait(20.0)), PERIOD)
    for count, (cart, theta1, theta2, *_) in enumerate(motion.advance(4000).tolist()):
        shadow.take(Position(BEGIN + count * 5_000_000, theta1, theta2 - theta1, cart))
    assert (shadow.phase, shadow.why) == (Phase.WAITING, "the pendulum came to rest")


def test_joints_may_mean_what_the_options_say():
    options = TrialOptions(zero="hanging", outer_angle="absolute")
    seen = fit_initial_states(Shadow(TRUE, options), *RELEASE, Wait(2.0), hanging=True)
    assert seen[-1].phase is Phase.BESIDE
    assert max(errors(seen).values()) < 1e-3


def test_a_motion_that_cannot_be_computed_is_told_and_the_next_release_awaited():
    shadow = Shadow(fitted_model(NOMINAL | {"c2": 1000.0}, "test"))
    with pytest.raises(CdpIdentError, match="cannot be computed"):
        fit_initial_states(shadow, *RELEASE, Wait(2.0))
    assert shadow.phase is Phase.WAITING


def test_time_that_goes_back_begins_anew():
    shadow = Shadow(TRUE)
    fit_initial_states(shadow, *RELEASE, Wait(1.0))
    shadow.take(Position(BEGIN, 1.8, 0.0, 0.0))
    assert (shadow.phase, shadow.why) == (Phase.WAITING, "the rig's time went back")


def test_it_stays_beside_a_rig_of_which_samples_are_missing():
    rig, shadow = fit_initial_states(Shadow(TRUE), *RELEASE, Wait(4.0)), Shadow(TRUE)
    gap = range(BEGIN + 3_500_000_000, BEGIN + 4_550_000_000)
    shown = [shadow.take(one.position) for one in rig if one.position.stamp_ns not in gap]
    assert shadow.phase is Phase.BESIDE
    assert max(abs(error) for one in shown for _, frame in one for error in frame.error or ()) < 1e-3
