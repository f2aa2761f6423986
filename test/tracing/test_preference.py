"""When what stands in the place of an effect is better."""

from unittest.mock import Mock

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.refinement import refine
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing import preference
from cdp_ident.tracing.evidence import Change
from cdp_ident.tracing.preference import is_better
from cdp_ident.tracing.refits import attempt_of

BY_KEY = {effect.key: effect for effect in CATALOGUE}
SMALL_SHARE = Mock(spec=Change, fit=100.0, validation=20.0, bic=-80.0, freedom=2.0)
"""Too much for chance, but a small share of the error."""


@pytest.mark.parametrize(("of_the_fall", "better"), [(0.4, True), (0.9, False)])
def test_a_richer_form_may_gain_a_small_share_where_nothing_that_is_missing_would_gain_as_much(
    of_the_fall, better, plain, monkeypatch
):
    def with_effect(key):
        active = ActiveEffect(BY_KEY[key])
        values = np.concatenate([plain.fit.values, [parameter.typical for parameter in active.fitted]])
        return attempt_of(refine(plain.model.with_effect(active), values, plain.fit.windows), plain.folds)

    more, dry = with_effect("stribeck_friction.outer"), with_effect("coulomb_friction.outer")
    missing = Mock(
        **{"ranked.return_value": [Mock(gain=of_the_fall * (dry.fit.squared_error - more.fit.squared_error))]}
    )
    monkeypatch.setattr(preference, "change", lambda before, after: SMALL_SHARE)
    monkeypatch.setattr(preference, "improves_enough", lambda before, after: False)
    monkeypatch.setattr(preference, "is_structured", lambda fit: False)
    monkeypatch.setattr(preference, "ScoreTest", lambda fit, candidates: missing)
    assert is_better(more, dry) == better
    monkeypatch.setattr(preference, "is_structured", lambda fit: True)
    assert not is_better(more, dry), "more than noise remains"
