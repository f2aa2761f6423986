# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""docs/how_to/own_effect.md is followed: a rub that the catalogue lacks is hidden in a rig that other equations
move."""

import json
import re
from pathlib import Path

import pytest

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.configuration.fitted_model import read_fitted_model
from cdp_ident.model.effects.catalogue import forget_own, known_effects
from cdp_ident.nodes.identify import main
from cdp_ident.report.report_file import read_report
from reference.truths import FIT_TRIALS, truth

DOCUMENT = (Path(__file__).parents[2] / "docs/how_to/own_effect.md").read_text(encoding="utf-8")
VISIBLE = 10.0
"""What the rub moves the angles by beyond imitation, over the noise."""


@pytest.fixture(scope="module")
def hidden():
    return truth("partial_rub.inner", 12, visible=VISIBLE)


@pytest.fixture(scope="module")
def folder(hidden, tmp_path_factory):
    """Return the folder of a report on the hidden truth's bags, beside them and the document's file."""
    folder = tmp_path_factory.mktemp("rig")
    bags = [_bag(folder / str(index), trial) for index, trial in enumerate(hidden.trials)]
    (block,) = re.findall(r"```yaml\n(.*?)```", DOCUMENT, re.DOTALL)
    (folder / "rub.yaml").write_text(block)
    values = hidden.setting.nominal
    known = {"L": values["L"], "g": values["g"], "nominal": {s: v for s, v in values.items() if s not in ("L", "g")}}
    (folder / "rig.yaml").write_text(json.dumps({"identify": {"ros__parameters": known}}))
    options = ["--effects", str(folder / "rub.yaml"), "--config", str(folder / "rig.yaml"), "--once"]
    fit, holdout = bags[:FIT_TRIALS], bags[FIT_TRIALS:]
    arguments = ["--bag", *fit, "--holdout", *holdout, *options, "--out", str(folder / "out")]
    try:
        assert main(arguments) == 0
    finally:
        forget_own()
    return folder / "out"


def _bag(folder, trial):
    with BagWriter(folder) as writer:
        for time, (theta1, theta2) in zip(trial.time[::2], trial.theta[::2], strict=True):
            stamp = 1_717_156_800_000_000_000 + round(time * 1e9)
            message = serialize_joint_state(("inner_joint", "outer_joint"), (theta1, theta2 - theta1), stamp)
            writer.write("/joint_states", MESSAGE_TYPE, stamp, message)
        writer.close()
    return str(folder)


def test_it_is_named_and_the_error_falls_to_the_noise(folder, hidden):
    report = read_report(folder / "report.json")
    forget_own()
    (effect,) = report["effects"]
    assert (effect["name"], effect["joint"], effect["certainty"]) == ("rub", "inner", "named")
    assert (
        effect["evidence"]["rmse_holdout_after_rad"]
        < 1.1 * hidden.floor
        < 0.25 * effect["evidence"]["rmse_holdout_before_rad"]
    )
    strength = effect["parameters"]["size"]
    assert abs(strength["value"] - hidden.hidden[0].strength) < 4.0 * strength["std"]
    assert not report["unexplained"]["significant"]


def test_the_page_shows_its_law_typeset(folder):
    assert "<mi>atan</mi>" in (folder / "report.html").read_text(encoding="utf-8")


def test_the_fitted_file_defines_it_and_needs_no_other(folder):
    assert not any(effect.name == "rub" for effect in known_effects())
    model = read_fitted_model(folder / "fitted.yaml", "simulator")
    assert [active.effect.key for active in model.motion.effects] == ["rub.inner"]
    forget_own()
