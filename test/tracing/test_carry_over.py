# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.tracing import carry_over
from cdp_ident.tracing.carry_over import Withdrawn, what_carries_over


@pytest.fixture
def judge(monkeypatch):
    """Return a function that judges the effects a, b, … by the errors of all models, which are known by their keys."""

    def judged_by(errors, missing=True, found="ab"):
        def model(keys):
            error_of = (lambda other: errors[other]) if keys else None
            return SimpleNamespace(holdout=SimpleNamespace(rmse=lambda: errors[keys]), error_of=error_of, keys=keys)

        def selection(keys):
            effects = [SimpleNamespace(key=key) for key in keys]
            return SimpleNamespace(
                after=SimpleNamespace(
                    model=SimpleNamespace(effects=effects), is_missing=np.array([missing, False]), keys=keys
                ),
                without=[without(keys, index) for index in range(len(keys))],
            )

        def withdrawn(of, index, options):
            return selection(without(of.after.keys, index))

        def without(keys, index):
            return "" if index is None else keys[:index] + keys[index + 1 :]

        monkeypatch.setattr(carry_over.FinalModel, "of", lambda whole, data: model(whole.keys))
        monkeypatch.setattr(carry_over, "withdrawn_from", withdrawn)
        after, chosen, _, left_out = what_carries_over(
            model(""), model(found), selection(found), SimpleNamespace(data=None, options=None)
        )
        assert after.keys == "".join(effect.key for effect in chosen.after.model.effects)
        return after.keys, left_out

    return judged_by


def test_an_effect_without_which_held_out_motion_is_predicted_better_is_withdrawn_where_torques_are_missing(judge):
    errors = {"": 40.0, "a": 4.0, "b": 30.0, "ab": 5.0}
    assert judge(errors) == ("a", Withdrawn(("b",), 5.0))
    assert judge(errors, missing=False) == ("ab", None)


def test_effects_are_withdrawn_one_by_one_the_worst_first(judge):
    errors = {"": 40.0, "abc": 9.0, "ab": 6.0, "ac": 8.0, "bc": 20.0, "a": 4.0, "b": 30.0}
    assert judge(errors, found="abc") == ("a", Withdrawn(("c", "b"), 9.0))


def test_by_chance_a_model_predicts_somewhat_better_without_an_effect(judge):
    assert judge({"": 40.0, "a": 4.95, "b": 30.0, "ab": 5.0}) == ("ab", None)


def test_all_go_where_the_paper_s_model_predicts_better_with_torques_missing_or_without(judge):
    errors = {"": 4.0, "a": 6.0, "b": 7.0, "ab": 5.0}
    assert judge(errors) == judge(errors, missing=False) == ("", Withdrawn(("a", "b"), 5.0))


def test_an_error_that_cannot_be_computed_withdraws_nothing(judge):
    assert judge({"": 40.0, "a": np.nan, "b": np.nan, "ab": 5.0}) == ("ab", None)
