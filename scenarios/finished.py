# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Finished identifications and their reports: of the example bags, and of trials one of which has a weight."""

from pathlib import Path

import numpy as np

from cdp_ident.configuration.settings import Settings
from cdp_ident.output_folder import json_text, write_files
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.contents import report
from cdp_ident.report.curves import Curves, curves, curves_npz
from cdp_ident.report.folder import CURVES, REPORT
from cdp_ident.report.outcome import Job, LoadedJob, Outcome
from cdp_ident.report.pictures import draw
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from scenarios.weighted import WEIGHT, dry_friction, plain_and_weighted

_BAGS = Path(__file__).parents[1] / "bags"


def of_example_bags() -> Outcome:
    """Return one of two bags, a third being held out."""
    bags = (_BAGS / "swing_wide", _BAGS / "swing_folded")
    return _of(Job(bags, (_BAGS / "swing_check",), Settings.of({})))


def of_one_bag() -> Outcome:
    """Return one of a single bag, part of which is held out."""
    return _of(Job((_BAGS / "swing_wide",), (), Settings.of({})))


def of_weighted_trials() -> Outcome:
    """Return one of two trials with dry friction, the second of which has a weight."""
    trials = plain_and_weighted(np.random.default_rng(5), torque=dry_friction)
    settings = Settings.of({f"trials.two.added.{WEIGHT.rod}": [WEIGHT.mass, WEIGHT.place]})
    job = Job((Path("one"), Path("two")), (), settings)
    return run(LoadedJob(job, tuple(trials), (), {}), lambda progress: None)


def _of(job: Job) -> Outcome:
    return run(load(job), lambda progress: None)


def content_of(outcome: Outcome) -> Section:
    """Return the report of a finished identification."""
    return report(outcome)


def curves_of(outcome: Outcome) -> Curves:
    """Return the curves of a finished identification."""
    return curves(outcome)


def write_report(folder: Path, content: Section, shown: Curves) -> None:
    """Write a report and all its pictures into a folder."""
    write_files(folder, {REPORT: json_text(content), CURVES: curves_npz(shown)})
    draw(folder, for_paper=True)


def report_in(folder: Path) -> Section:
    """Read the report of a folder."""
    return read_report(folder / REPORT)
