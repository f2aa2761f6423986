# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags are read once each, and checked before any work is done."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.configuration.settings import Settings
from cdp_ident.errors import OptionError
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.contents import report
from cdp_ident.report.outcome import Job
from scenarios.clean_bags import write_clean_bags

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


def test_a_sentence_ends_the_search_whose_best_is_refined_all_the_same(tmp_path):
    write_clean_bags(tmp_path, swing=6.0)
    loaded = load(job([tmp_path / "swing_wide"], method="iga"))
    outcome = run(loaded, lambda progress: "enough" if progress.generation == 3 else None)
    search = outcome.identification.search
    assert (search.stopped, len(search.history)) == ("enough", 4)
    assert not search.completed
    assert outcome.identification.fit.rmse() < 0.1
    assert 0.0 < outcome.search_seconds <= outcome.seconds


def with_spikes(bag, folder, rng):
    """Copy a bag, with a spike of up to a radian in one of the encoders in every hundredth of its samples."""
    with AnyReader([bag]) as reader, BagWriter(folder / bag.name) as writer:
        for connection in reader.connections:
            writer.add_topic(connection.topic, connection.msgtype)
        for connection, stamp, raw in reader.messages():
            copied = bytes(raw)
            if connection.msgtype == MESSAGE_TYPE and rng.random() < 0.01:
                message = reader.deserialize(raw, connection.msgtype)
                positions = np.array(message.position)
                positions[message.name.index(rng.choice(["inner_joint", "outer_joint"]))] += rng.uniform(-1.0, 1.0)
                own = message.header.stamp
                copied = serialize_joint_state(message.name, positions, own.sec * 1_000_000_000 + own.nanosec)
            writer.write(connection.topic, connection.msgtype, stamp, copied)
        writer.close({})
    return folder / bag.name


@pytest.mark.parametrize(
    "of", ["outcome_alone", pytest.param("outcome", marks=pytest.mark.campaign)], ids=["one bag", "three bags"]
)
def test_spikes_in_one_of_a_hundred_samples_change_no_name_and_no_group(of, request, tmp_path):
    outcome = request.getfixturevalue(of)
    rng = np.random.default_rng(3)
    bags, holdout = (
        [with_spikes(bag, tmp_path, rng) for bag in bags]
        for bags in (outcome.loaded.job.bags, outcome.loaded.job.holdout)
    )
    spiked = run(load(job(bags, holdout)), lambda progress: None)
    for trial, clean in zip(
        (*spiked.loaded.fit, *spiked.loaded.holdout), (*outcome.loaded.fit, *outcome.loaded.holdout), strict=True
    ):
        assert 10 < len(trial.outliers) == pytest.approx(len(clean.time) - len(trial.time), abs=2)

    def names(found):
        return [
            (effect.active.effect.name, effect.active.effect.joint, effect.certainty) for effect in found.trace.effects
        ]

    assert names(spiked) == names(outcome) != []
    assert spiked.trace.unexplained.significant == outcome.trace.unexplained.significant
    for role in ("fit", "holdout"):
        error, before = (getattr(found.trace.errors["effects"], role).rmse for found in (spiked, outcome))
        assert error == pytest.approx(before, rel=0.03)
    std = np.sqrt(np.diag(outcome.trace.completed.covariance))
    shift = (spiked.trace.completed.fit.values - outcome.trace.completed.fit.values) / std
    # That a hundredth of the samples is lost moves each by a tenth of its deviation, root mean square.
    assert np.sqrt(np.mean(shift**2)) < 0.2
    content = report(spiked)
    warned = [warning["message"] for warning in content["warnings"] if warning["name"] == "outliers"]
    assert len(warned) == len(bags) + len(holdout)
    assert [trial["outliers_s"] for trial in content["trials"]] == [
        list(trial.outliers) for trial in (*spiked.loaded.fit, *spiked.loaded.holdout)
    ]
