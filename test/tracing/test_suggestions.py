# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where more than noise is left, what scores say too little of is suggested."""

import numpy as np
import pytest

from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.formulas.language import COEFFICIENTS
from cdp_ident.tracing.missing_torque import MissingTorque
from cdp_ident.tracing.suggestions import suggestions

DRY = "coulomb_friction.outer"


def test_modes_of_the_base_are_proposed_with_more_than_the_rods_mass_and_of_encoders_from_several_compliances(rubbing):
    proposed = [each for each in suggestions(rubbing) if each.model.effects[-1].effect.law.cart]
    frequencies = [each.values[-2] for each in proposed]
    np.testing.assert_allclose(np.divide(frequencies[1:], frequencies[:-1]), 2.0)
    for each in proposed:
        compliance, frequency, _ = each.values[-3:]
        A23, A33, a1, *_ = each.values
        rods = a1**2 + (A23 / each.model.coefficients(each.values)[COEFFICIENTS.index("L")]) ** 2 / A33
        assert 1.0 / (compliance * frequency**2) == pytest.approx(4.0 * rods)
    keys = [f"encoder_compliance.{joint}.oscillating" for joint in JOINTS for _ in range(3)]
    behind = [each for each in suggestions(rubbing) if each.what in {(key,) for key in keys}]
    assert [each.what[0] for each in behind] == keys
    assert len({each.values[-2] for each in behind}) == 3


def test_what_both_encoders_do_alike_is_proposed_for_both(rubbing):
    both = [each for each in suggestions(rubbing) if len(each.what) == 2]
    kinds = ["encoder_compliance.inner.oscillating", "encoder_filter.inner.first order", "backlash.inner"]
    assert [each.what[0] for each in both] == [kind for kind in kinds for _ in range(3)]
    for each in both:
        assert each.what[1] == each.what[0].replace("inner", "outer")
        inner, outer = np.split(each.values[len(rubbing.values) :], 2)
        np.testing.assert_array_equal(inner, outer)
        assert np.all(inner > 0.0)
        assert each.unscored


def test_dry_friction_is_proposed_in_joints_where_a_torque_is_missing_and_play_everywhere(rubbing, clean):
    dry, *others = suggestions(rubbing)
    play = [each.what for each in others if each.what[0].startswith("backlash")]
    both = ("backlash.inner", "backlash.outer")
    assert (dry.what, play) == ((DRY,), [what for what in (both[:1], both[1:], both) for _ in range(3)])
    elastic = [each for each in others if each.model.effects[-1].effect.remembers]
    missing = np.sqrt(np.mean(MissingTorque.of(rubbing).torque[:, 1] ** 2))
    assert dry.values[-1] == pytest.approx(missing)
    assert {each.what for each in elastic} == {("presliding_friction.outer",)}
    assert [each.values[-2] for each in elastic] == pytest.approx([missing] * 3)
    assert len({each.values[-1] for each in elastic}) == 3  # how far it gives way
    assert not [*suggestions(clean)]
