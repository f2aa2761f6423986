"""The package as a user has it: trials and nominal values in, names and errors out. Nothing else here imports it."""

from collections.abc import Sequence
from dataclasses import dataclass

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import Trace, trace
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
    """Error on the trial that it never saw, without effects [rad]."""
    after: float
    """The same with the effects that it named [rad]."""
    remains: bool
    """Whether more than noise is said to remain."""
    description: str
    """Of what remains."""
    unknown: tuple[str, ...] = ()
    """Keys of torques that were found and have no name."""


def identified(truth: Truth) -> Identification:
    """Identify the paper's model from a truth's first trials."""
    trials = _trials(truth.trials)
    options = IdentifyOptions(prior=Prior(nominal=truth.setting.nominal))
    return identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], options)


def traced(truth: Truth) -> Trace:
    """Identify a truth's rig from its first trials, and trace what is left to effects."""
    return trace(identified(truth))


def found(truth: Truth) -> Found:
    """Return what the package names in a truth's trials."""
    return answer_of(traced(truth))


def answer_of(traced: Trace) -> Found:
    """Return what a trace says, in the words of an answer sheet."""
    named = []
    for effect in traced.effects:
        if effect.certainty == "acts_like":
            continue  # these are no names
        own = effect.active.effect
        others = (other.split()[:2] for other in effect.also_possible)
        named.append(Named(own.key, (own.name, str(own.joint)), tuple((name, joint) for name, joint in others)))
    return Found(
        tuple(named),
        traced.before.holdout.rmse(),
        traced.after.holdout.rmse(),
        traced.unexplained.significant,
        traced.unexplained.description,
        tuple(effect.active.effect.key for effect in traced.effects if effect.curve),
    )


def _trials(measured: Sequence[Measured]) -> list[Trial]:
    return [Trial(trial.name, trial.time, trial.theta) for trial in measured]
