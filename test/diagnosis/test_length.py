# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A length that was given wrongly is seen in the balance of forces."""

import re
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.length import LengthByBalance, length_by_balance, says_another_length
from cdp_ident.fit.force_balance import Pieces, balance_of_forces
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from reference.truths import truth
from scenarios.twin import TEN_SECONDS, twin

TRUE = TABLE_5["L"]


@pytest.fixture(scope="module")
def balances():
    trial = twin(np.random.default_rng(0), start=(2.2, 2.6, 0.0, 0.0), times=TEN_SECONDS, noise=5e-4, tolerance=1e-8)

    def compute(given):
        pieces = Pieces.of([trial], given, 9.81)
        return tuple(balance_of_forces(pieces, length_free=free) for free in (False, True))

    return compute


@pytest.mark.parametrize("share", [0.98, 1.012])
def test_a_length_that_is_off_is_told_with_the_right_one(balances, share):
    given, free = balances(share * TRUE)
    found = length_by_balance(given, free, share * TRUE)
    assert found.found == pytest.approx(TRUE, abs=4 * found.std)
    assert found.std < 0.002 * TRUE
    assert found.words.startswith("by the balance of forces L is 0.4")
    assert found.words.endswith(f" % from the {share * TRUE:g} m given")
    assert says_another_length(given, found) == ""


@pytest.mark.parametrize("share", [1.0, 1.001])
def test_one_that_is_right_or_off_by_nothing_that_matters_is_not(balances, share):
    assert length_by_balance(*balances(share * TRUE), share * TRUE) is None


def test_what_no_pendulum_of_this_length_does_is_refused_with_the_length_that_would_do(balances):
    given, free = balances(4 * TRUE)
    said = says_another_length(given, length_by_balance(given, free, 4 * TRUE))
    assert re.search(r"do not balance; by the balance of forces L is 0\.4.* from the 1\.6 m given", said)


def test_motion_that_no_length_balances_is_not_refused_for_its_length():
    # 57 mrad of play between the inner joint of a small rig and its encoder.
    made = truth("backlash.inner+coulomb_friction.inner", 9791)
    trials = [Trial(measured.name, measured.time, measured.theta) for measured in made.trials[:2]]
    length = made.setting.nominal["L"]
    pieces = Pieces.of(trials, length, 9.81)
    given, free = (balance_of_forces(pieces, length_free=free) for free in (False, True))
    assert np.any(given.unexplained > 0.3)
    assert says_another_length(given, length_by_balance(given, free, length)) == ""
    no_better = LengthByBalance(length, 0.5 * length, 0.01 * length, balances=False)
    assert says_another_length(given, no_better) == ""
    assert says_another_length(given, replace(no_better, balances=True)) != ""
