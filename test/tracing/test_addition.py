"""Additions that whole truths rarely show one by one."""

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing import addition
from cdp_ident.tracing.addition import add_effects
from cdp_ident.tracing.candidates import Candidate, Pair, ScoreTest
from cdp_ident.tracing.progress import Progress

BY_KEY = {effect.key: effect for effect in CATALOGUE}


def typical(key):
    active = ActiveEffect(BY_KEY[key])
    strengths = np.array([parameter.typical for parameter in active.fitted if not parameter.shape])
    return Candidate(active, 1.0, strengths)


def test_of_a_pair_that_is_tried_the_stronger_effect_is_tried_alone_as_well(plain, monkeypatch):
    # A score test that shows the spring beside a drag alone, as where the motion is too chaotic for it.
    pair = Pair((typical("air_drag.outer.rotation"), typical("joint_spring.outer")), plain.fit.squared_error, 1.0)
    monkeypatch.setattr(addition, "_one_by_one", lambda progress, test: [])
    monkeypatch.setattr(addition, "_oscillating", lambda progress: [])
    monkeypatch.setattr(ScoreTest, "pairs", lambda test, most: [pair])
    progress = Progress(plain, 5e-4)
    add_effects(progress)
    assert progress.current.model.labels == ("joint_spring.outer",)
    first, *_ = progress.steps
    assert {of.effects for of in first.tried} == {
        ("air_drag.outer.rotation", "joint_spring.outer"),
        ("joint_spring.outer",),
    }
