# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The package as a user has it: trials and nominal values in, names and errors out. Nothing else here imports it."""

import contextlib
import sys
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.pipeline.identify import identify, identify_and_trace
from cdp_ident.tracing.trace import Trace
from cdp_ident.trial.trial import Trial
from reference.truths import FIT_TRIALS, Measured, Truth


@dataclass(frozen=True)
class Named:
    """An effect that was named."""

    key: str
    identity: tuple[str, str]
    """Name and joint."""
    also_possible: tuple[tuple[str, str], ...]
    """Those of effects that are said to be as possible."""
    probability: float = 1.0
    """That it is there, as it is said."""


@dataclass(frozen=True)
class Found:
    """What the package makes of a truth's trials."""

    named: tuple[Named, ...]
    before: float
    """Error on the trial that it never saw, without effects, of all samples alike, as a truth's floor is [rad]."""
    after: float
    """The same with the effects that it named [rad]."""
    remains: bool
    """Whether more than noise is said to remain."""
    description: str
    """Of what remains."""
    base: tuple[tuple[float, float], ...] = ()
    """Base parameters over A22, and their standard deviations."""
    unknown: tuple[str, ...] = ()
    """Keys of torques that were found and have no name."""
    alike: tuple[str, ...] = ()
    """The known shapes that these are said to be similar to."""

    @property
    def said(self) -> str:
        """All that is said, without the numbers."""
        named = [f"{one.key} or {one.also_possible}" for one in self.named]
        return "; ".join((*named, *self.unknown, *self.alike, self.description))


def identified(truth: Truth) -> Identification:
    """Identify the paper's model from a truth's first trials."""
    return identify(*_given(truth))


def traced(truth: Truth, method: Literal["iga", "tga"] | None = None) -> Trace:
    """Identify a truth's rig from its first trials, by the paper's search or not, and trace what is left to effects."""
    fit, holdout, options = _given(truth)
    return identify_and_trace(fit, holdout, replace(options, method=method))[1]


@contextlib.contextmanager
def catalogue_without(names: Collection[str]) -> Iterator[None]:
    """Take effects out of the catalogue for a while."""
    modules = [of for of in [*sys.modules.values()] if getattr(of, "known_effects", None) is known_effects]
    known = known_effects
    for module in modules:
        vars(module)["known_effects"] = lambda: tuple(e for e in known() if e.name not in names)
    try:
        yield
    finally:
        for module in modules:
            vars(module)["known_effects"] = known


def found(truth: Truth) -> Found:
    """Return what the package names in a truth's trials."""
    return answer_of(traced(truth))


def answer_of(traced: Trace) -> Found:
    """Return what a trace says, in the words of an answer sheet."""
    named = []
    for one in traced.effects:
        if one.certainty == "acts_like":
            continue  # these are no names
        own = one.active.effect
        others = (other.split(".")[:2] for other in one.also_possible)
        as_possible = tuple((name, joint) for name, joint in others)
        named.append(Named(own.key, (own.name, str(own.joint)), as_possible, one.probability))
    return Found(
        tuple(named),
        traced.before.holdout.rmse(),
        traced.after.holdout.rmse(),
        traced.unexplained.significant,
        traced.unexplained.description,
        tuple(
            zip(traced.completed.fit.values[:5].tolist(), np.sqrt(np.diag(traced.covariance)[:5]).tolist(), strict=True)
        ),
        tuple(one.active.effect.key for one in traced.effects if one.certainty == "acts_like"),
        tuple(one.curve.likeness for one in traced.effects if one.curve),
    )


def _given(truth: Truth) -> tuple[list[Trial], list[Trial], IdentifyOptions]:
    """Return a truth's trials to fit and to hold out, and the options with its nominal values."""
    trials = _trials(truth.trials)
    return trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions(prior=Prior(nominal=truth.setting.nominal))


def _trials(measured: Sequence[Measured]) -> list[Trial]:
    return [Trial(trial.name, trial.time, trial.theta) for trial in measured]
