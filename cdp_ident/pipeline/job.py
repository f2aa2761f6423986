# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From bags to an identification: what `identify` does, without ROS and without a terminal."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from cdp_ident.bag.reader import bag_checksums
from cdp_ident.configuration.settings import Settings
from cdp_ident.errors import OptionError
from cdp_ident.model.parameters import SYMBOLS
from cdp_ident.model.weights import ADDED, RODS, Rod, Weight, refuse_misplaced
from cdp_ident.pipeline.compile_ahead import compile_ahead
from cdp_ident.pipeline.identify import identify_and_trace
from cdp_ident.report.outcome import Job, LoadedJob, Outcome
from cdp_ident.search.genetic_search import Progress
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.trial import Trial
from cdp_ident.user_input import refuse_unknown


def load(job: Job, more_to_come: bool = False) -> LoadedJob:
    """Read a job's bags; `more_to_come` says whether the settings may speak of bags that are not there yet.

    Raises:
        OptionError: no bag is given, or one is given twice, or a weight is of no bag, or far off its rod.
        BagError: a bag cannot be read.
        TrialError: a bag holds no trial.
    """
    compile_ahead()
    if not job.bags:
        raise OptionError("there is nothing to identify from: give at least one --bag, or a folder to --watch")
    checksums = refuse_copies((*job.bags, *job.holdout))
    trials = [load_with_weights(bag, job.settings) for bag in (*job.bags, *job.holdout)]
    names = [trial.name for trial in trials]
    if not more_to_come:
        refuse_unknown(job.settings.weights, names, "bag of a weight (trials.<bag>.added)")
    for name in job.settings.weights:
        if names.count(name) > 1:
            raise OptionError(f"trials.{name}.added: {names.count(name)} bags have this name; rename one of them")
    count = len(job.bags)
    return LoadedJob(job, tuple(trials[:count]), tuple(trials[count:]), checksums)


def load_with_weights(bag: Path, settings: Settings) -> Trial:
    """Load a bag's trial, with the weights that the settings give it or, for a rod that they leave out, the bag.

    Raises:
        OptionError: a weight is far off its rod.
        BagError: the bag cannot be read.
        TrialError: it holds no trial.
    """
    trial, prior = load_trial(bag, settings.trial), settings.identify.prior
    recorded: dict[Rod, Weight | None] = {weight.rod: weight for weight in trial.weights}
    weights = recorded | dict(settings.weights.get(trial.name, {}))
    chosen = tuple(weight for rod in RODS if (weight := weights.get(rod)))
    lengths: dict[Rod, float] = {"inner": prior.length, "outer": settings.identify.model.mechanism.outer_length}
    pendulum = float(sum(prior.centre[SYMBOLS.index(mass)] for mass in ("m1", "m2", "m0")))
    for weight in chosen:
        refuse_misplaced(weight, lengths[weight.rod], pendulum, f"trials.{trial.name}.{ADDED}.{weight.rod}")
    return replace(trial, weights=chosen)


def refuse_copies(bags: Sequence[Path]) -> dict[Path, dict[str, str]]:
    """Return the checksums of the files of bags.

    Raises:
        OptionError: two bags have a file in common.
        BagError: a file cannot be read.
    """
    checksums: dict[Path, dict[str, str]] = {}
    owner: dict[str, Path] = {}
    for bag in bags:
        sums = bag_checksums(bag)
        for digest in sums.values():
            if digest in owner:
                other = owner[digest]
                same = f"{bag} is given twice" if bag == other else f"{bag} and {other} are the same bag"
                raise OptionError(f"{same}: each may be used once, to fit or as --holdout")
        owner |= dict.fromkeys(sums.values(), bag)
        checksums[bag] = sums
    return checksums


def run(
    loaded: LoadedJob,
    stop: Callable[[Progress], str | None],
    say: Callable[[str], None] = lambda line: None,
    stop_tracing: Callable[[], bool] = lambda: False,
    trying: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """Do a job; what is called meanwhile, and what is raised, are those of `identify_and_trace`."""
    began = searched = time.monotonic()

    def clocked(progress: Progress) -> str | None:
        nonlocal searched
        searched = time.monotonic()
        return stop(progress)

    job = loaded.job
    found, traced = identify_and_trace(
        loaded.fit, loaded.holdout, job.settings.identify, clocked, say, stop_tracing, trying, job.expected
    )
    return Outcome(loaded, found, traced, searched - began, time.monotonic() - began)
