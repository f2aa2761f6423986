"""Bags are read once each, and checked before any work is done."""

import shutil
from pathlib import Path

import pytest

from cdp_ident.configuration.settings import Settings
from cdp_ident.errors import BagError, OptionError, TrialError
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.outcome import Job

BAGS = Path(__file__).parents[2] / "bags"
WIDE, FOLDED = BAGS / "swing_wide", BAGS / "swing_folded"


def job(bags, holdout=(), **values):
    return Job(tuple(bags), tuple(holdout), Settings.of(values))


def test_bags_are_read_in_their_roles():
    loaded = load(job([WIDE], [FOLDED]))
    assert [trial.name for trial in loaded.fit] == ["swing_wide"]
    assert [trial.name for trial in loaded.holdout] == ["swing_folded"]
    assert list(loaded.checksums) == [WIDE, FOLDED]


@pytest.mark.parametrize(
    ("bags", "holdout", "words"),
    [
        ([], [], "at least one --bag"),
        ([WIDE, WIDE], [], "is given twice"),
        ([WIDE], [WIDE], "is given twice"),
        ([WIDE, WIDE / "swing_wide_0.mcap"], [], "are the same bag"),
        ([WIDE], [WIDE / "metadata.yaml"], "are the same bag"),
    ],
)
def test_a_bag_is_used_once(bags, holdout, words):
    with pytest.raises(OptionError, match=words):
        load(job(bags, holdout))


def test_a_copy_of_a_bag_is_the_same_bag(tmp_path):
    shutil.copytree(WIDE, tmp_path / "other")
    with pytest.raises(OptionError, match="are the same bag"):
        load(job([WIDE], [tmp_path / "other"]))


def test_what_is_no_bag_or_no_trial_is_refused(tmp_path):
    with pytest.raises(BagError, match="nowhere"):
        load(job([tmp_path / "nowhere"]))
    with pytest.raises(BagError, match="no topic"):
        load(job([WIDE], **{"trial.topic": "other"}))
    with pytest.raises(TrialError, match="elbow"):
        load(job([WIDE], **{"trial.inner_joint": "elbow"}))


def test_a_sentence_ends_the_search_whose_best_is_refined_all_the_same():
    outcome = run(load(job([WIDE], method="iga")), lambda progress: "enough" if progress.generation == 3 else None)
    search = outcome.identification.estimate.search
    assert (search.stopped, len(search.history)) == ("enough", 4)
    assert outcome.identification.interrupted
    assert outcome.identification.fit.rmse() < 0.1
    assert 0.0 < outcome.search_seconds <= outcome.seconds
