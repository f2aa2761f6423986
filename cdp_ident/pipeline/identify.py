"""The whole identification of the paper's model: trials in, parameters with intervals and errors out."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.continuity import Continuity, continuity
from cdp_ident.diagnosis.evaluation import Errors, follow, judge, odd_window
from cdp_ident.diagnosis.repeatability import Repeatability, repeatability
from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.errors import IdentificationError, OptionError
from cdp_ident.fit.estimation import PAPER_SPAN, SHORT_IGA, Estimate, estimate
from cdp_ident.fit.motion_model import Mechanism, MotionModel
from cdp_ident.fit.noise import noise_of
from cdp_ident.fit.physical import PhysicalValues, nearest_physical_values
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine_from_afar
from cdp_ident.fit.windows import DEFAULT_WINDOW, Window, cut_into_windows
from cdp_ident.model.parameters import GROUPS, groups_of
from cdp_ident.search.genetic_search import Progress
from cdp_ident.search.options import METHODS, GeneticOptions
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]
Stage = Literal["nominal", "search", "refined"]

_EVERY = 4
"""Without trials to judge by, every fourth window is kept out of the fit."""
_FIRST, _ANOTHER_FIRST = 2, 1
"""Index of the first of them, and the one taken where that would keep out a window in which something happened."""
_ODD = 1.5
"""Such a window's error is at least so many times the others'."""
_FEWEST_WINDOWS = 4
_SHORTEST_WINDOW = 0.5


@dataclass(frozen=True)
class IdentifyOptions:
    """How trials are identified."""

    prior: Prior = field(default_factory=Prior)
    """Nominal and known values, and the box of the search."""
    method: Literal["iga", "tga"] | None = None
    """The paper's search in full, by name; None: the improved one, cut short, as the refinement takes over from it."""
    genetic: GeneticOptions | None = None
    """The search's settings, where they are not those of the method."""
    seed: int = 1
    """Seed of the only random generator."""
    window: float = DEFAULT_WINDOW
    """Length of the windows of refinement and judgement [s]."""
    length_free: bool = False
    """Whether L is fitted too."""
    gravity_free: bool = False
    """Whether g is fitted too."""

    def __post_init__(self) -> None:
        if not _SHORTEST_WINDOW <= self.window < math.inf:
            raise OptionError(f"window is {self.window} s; it must be at least {_SHORTEST_WINDOW} s")
        if self.method is not None and self.method not in METHODS:
            raise OptionError(f"method is {self.method!r}; it must be one of {', '.join(METHODS)}")

    @property
    def search(self) -> GeneticOptions:
        """The search's settings."""
        return self.genetic or (METHODS[self.method] if self.method else SHORT_IGA)

    @property
    def span(self) -> float:
        """How long the search simulates from one start [s]."""
        return PAPER_SPAN if self.method else self.window

    @property
    def model(self) -> MotionModel:
        """The model to be fitted."""
        return MotionModel(Mechanism.of(self.prior), self.length_free, self.gravity_free)


@dataclass(frozen=True)
class Data:
    """Trials cut into the windows that are fitted and those that are only judged by."""

    trials: tuple[Trial, ...]
    """The trials to fit, then those to judge by."""
    held_out: int
    """How many trials, at the end, are only judged by; 0 where windows of the others are kept out instead."""
    fit: tuple[Window, ...]
    holdout: tuple[Window, ...]
    noise: Array
    """(2,) standard deviation of the noise of theta1 and theta2 over all trials to fit [rad]."""

    @property
    def names(self) -> list[str]:
        """Names of the trials."""
        return [trial.name for trial in self.trials]


@dataclass(frozen=True)
class Identification:
    """What trials say about the paper's model."""

    options: IdentifyOptions
    data: Data
    estimate: Estimate
    covariance: Array
    """(unknowns, unknowns) covariance of the fitted values."""
    physical: PhysicalValues
    errors: dict[Stage, tuple[Errors, Errors]]
    """Errors over the fitted and over the held-out windows, of each stage on the way."""
    continuity: Continuity | None
    repeatability: Repeatability | None
    interrupted: bool

    @property
    def fit(self) -> Fit:
        """The refined fit."""
        return self.estimate.fit


def prepare(fit: Sequence[Trial], holdout: Sequence[Trial], window: float, first: int = _FIRST) -> Data:
    """Cut trials into windows, and decide which are kept out of the fit where no trial is.

    Args:
        fit: trials to fit.
        holdout: trials to judge by; if there is none, every fourth window of the others is kept out of the fit.
        window: length of a window [s]; shorter where the trials would give too few otherwise.
        first: index of the first window that is kept out.

    Raises:
        IdentificationError: the trials are too short.
    """
    if not fit:
        raise IdentificationError("there is no trial to fit: give at least one bag")
    trials = (*fit, *holdout)
    if not holdout:
        window = min(window, sum(trial.duration for trial in fit) / _FEWEST_WINDOWS)
    if window < _SHORTEST_WINDOW:
        total = sum(trial.duration for trial in fit)
        raise IdentificationError(
            f"the trials hold {total:.1f} s of motion; at least {_FEWEST_WINDOWS * _SHORTEST_WINDOW:.0f} s are needed"
        )
    windows = cut_into_windows(trials, window)
    if holdout:
        fitted = [w for w in windows if w.trial < len(fit)]
        kept_out = [w for w in windows if w.trial >= len(fit)]
    else:
        fitted = [w for index, w in enumerate(windows) if index % _EVERY != first]
        kept_out = windows[first::_EVERY]
    if not fitted or not kept_out:
        raise IdentificationError("the trials have too few samples to fit and to judge by: record longer ones")
    noise = np.sqrt(np.mean([noise_of(trial) ** 2 for trial in fit], axis=0))
    return Data(trials, len(holdout), tuple(fitted), tuple(kept_out), noise)


def identify(
    fit: Sequence[Trial],
    holdout: Sequence[Trial],
    options: IdentifyOptions,
    stop: Callable[[Progress], str | None] = lambda progress: None,
) -> Identification:
    """Identify the paper's model from trials.

    Args:
        fit: trials to fit jointly.
        holdout: trials to judge by, which the fit never sees.
        options: how.
        stop: called after each generation of the search; a sentence that it returns ends the search, of which the
            best so far is then refined.

    Raises:
        IdentificationError: the trials do not suffice.
    """
    data = prepare(fit, holdout, options.window)
    model, prior = options.model, options.prior
    rng = np.random.default_rng(options.seed)
    noise = float(np.sqrt(np.mean(data.noise**2)))
    found = estimate(model, data.fit, prior, noise, rng, options.search, options.span, stop)
    if not holdout and _odd_window_is_kept_out(found.fit, data):
        # What happened once is found where it is fitted, and nowhere else.
        data = prepare(fit, holdout, options.window, _ANOTHER_FIRST)
        found = replace(found, fit=refine_from_afar(model, found.fit.values, data.fit))
    values = found.fit.values
    stages: dict[Stage, Array] = {
        "nominal": model.beginning(groups_of(prior.centre, prior.length)),
        "search": model.beginning(groups_of(found.search.best, prior.length)),
        "refined": values,
    }
    spread = covariance(found.fit)
    count = len(GROUPS)
    physical = nearest_physical_values(values[:count], spread[:count, :count], prior, model.constants(values)[0])
    return Identification(
        options=options,
        data=data,
        estimate=found,
        covariance=spread,
        physical=physical,
        errors={
            stage: (
                judge(model, stage_values, data.fit, data.trials),
                judge(model, stage_values, data.holdout, data.trials),
            )
            for stage, stage_values in stages.items()
        },
        continuity=continuity(found.fit),
        repeatability=repeatability(found.fit, data.names),
        interrupted=not found.search.completed,
    )


def _odd_window_is_kept_out(fit: Fit, data: Data) -> bool:
    assert isinstance(fit.model, MotionModel)
    odd = odd_window((fit, follow(fit.model, fit.values, data.holdout)), data.noise, _ODD)
    return odd is not None and (odd[0].trial, odd[0].begin) in {(w.trial, w.begin) for w in data.holdout}
