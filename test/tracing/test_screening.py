"""Which candidates are refitted."""

import numpy as np

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.candidates import ScoreTest, addable
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.screening import is_worth_a_look, promising
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, twin

EFFECTS = {effect.key: effect for effect in CATALOGUE}


def magnet(time, state):
    torque = -0.03 * np.exp(-((state[1] - state[0]) ** 2) / 0.02) * (state[1] - state[0])
    return -torque, torque


def harmonics_of_outer(ranked):
    effects = [candidate.active.effect for candidate in ranked]
    return [effect.key for effect in effects if effect.harmonic and effect.joint == "outer"]


def test_the_many_harmonics_that_imitate_one_torque_leave_room_for_others():
    trial = twin(np.random.default_rng(0), start=(2.2, 2.6, 0.0, 0.0), times=TEN_SECONDS, noise=1e-5, torque=magnet)
    windows = cut_into_windows([trial], 1.25)
    truth = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    attempt = attempt_of(refine(MotionModel(Mechanism.of(Prior())), truth, windows), ((0, 2, 4, 6), (1, 3, 5, 7)))
    test = ScoreTest(attempt.fit, addable(attempt.model))
    nearby = ScoreTest(attempt.closely, test.candidates)
    worth = [c.active.effect for c in test.ranked() if is_worth_a_look(attempt.fit, c)]
    found = {candidate.active.effect.key for candidate in promising(attempt, test, len(worth))}
    best = {key for ranked in (test.ranked(), nearby.ranked()) for key in harmonics_of_outer(ranked)[:3]}
    assert {effect.key for effect in worth if effect.harmonic and effect.joint == "outer"} - best
    assert {key for key in found if EFFECTS[key].harmonic and EFFECTS[key].joint == "outer"} <= best
    assert {effect.key for effect in worth if not effect.harmonic} <= found
