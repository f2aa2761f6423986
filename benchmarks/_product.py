"""The package as a user has it: trials and nominal values in, names and errors out. Nothing else here imports it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.diagnosis.inertia import Inertia
from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit
from cdp_ident.pipeline.identify import identify
from cdp_ident.pipeline.identify_and_trace import identify_and_trace
from cdp_ident.tracing.certainty import confirmed
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.found_effects import found_effects
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.trace import Trace, select_effects
from cdp_ident.tracing.unexplained import Unexplained, unexplained
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
    unknown: tuple[str, ...] = ()
    """Keys of torques that were found and have no name."""
    alike: tuple[str, ...] = ()
    """The known shapes that these are said to be similar to; only of `chosen`."""

    @property
    def said(self) -> str:
        """All that is said, without the numbers."""
        named = [f"{one.key} or {one.also_possible}" for one in self.named]
        return "; ".join((*named, *self.unknown, *self.alike, self.description))


def identified(truth: Truth) -> Identification:
    """Identify the paper's model from a truth's first trials."""
    return identify(*_given(truth))


def traced(truth: Truth) -> Trace:
    """Identify a truth's rig from its first trials, and trace what is left to effects."""
    return identify_and_trace(*_given(truth))[1]


def found(truth: Truth) -> Found:
    """Return what the package names in a truth's trials."""
    return answer_of(traced(truth))


def answer_of(traced: Trace) -> Found:
    """Return what a trace says, in the words of an answer sheet."""
    return _answer(traced.selection, traced.before, traced.after, traced.unexplained)


def chosen(found: Identification) -> Found:
    """Return what the package names when it traces an identification, without the rest of its report."""
    selection, _ = select_effects(found)
    before, after = (FinalModel.of(attempt.fit, found.data) for attempt in (selection.before, selection.after))
    selection = confirmed(selection, before, after)
    spread, unknown = covariance(after.fit), [np.nan] * len(selection.without)
    left = unexplained(after, found.data.noise, found.data.names, found.inertia.value, spread)
    inertia = Inertia.of(after.model, after.fit.values, spread, found.physical)
    effects = found_effects(selection, after, after.fit, unknown, spread, inertia)
    alike = tuple(effect.curve.likeness for effect in effects if effect.curve)
    return replace(_answer(selection, before, after, left), alike=alike)


def _answer(selection: Selection, before: FinalModel, after: FinalModel, left: Unexplained) -> Found:
    effects = [active.effect for active in selection.after.model.effects]
    named = []
    for own, certainty, also_possible in zip(effects, selection.certainty, selection.also_possible, strict=True):
        if certainty == "acts_like":
            continue  # these are no names
        others = (other.split()[:2] for other in also_possible)
        named.append(Named(own.key, (own.name, str(own.joint)), tuple((name, joint) for name, joint in others)))
    return Found(
        tuple(named),
        error_of_samples(before.holdout),
        error_of_samples(after.holdout),
        left.significant,
        left.description,
        tuple(effect.key for effect in effects if effect.curve),
    )


def error_of_samples(fit: Fit) -> float:
    """Return the root mean square error of both angles [rad]; readings that a joint at rest repeats count, too."""
    return float(np.sqrt(np.mean(np.concatenate(fit.errors) ** 2)))


def _given(truth: Truth) -> tuple[list[Trial], list[Trial], IdentifyOptions]:
    """Return a truth's trials to fit and to hold out, and the options with its nominal values."""
    trials = _trials(truth.trials)
    return trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions(prior=Prior(nominal=truth.setting.nominal))


def _trials(measured: Sequence[Measured]) -> list[Trial]:
    return [Trial(trial.name, trial.time, trial.theta) for trial in measured]
