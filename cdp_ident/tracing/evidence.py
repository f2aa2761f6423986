"""How much a change of the squared error means, where residuals are correlated in time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.cross_validation import Folds, cross_validated
from cdp_ident.diagnosis.uncertainty import covariance, curvature, effective_unknowns, scaled_inverse, variance_ratio
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit, refine
from cdp_ident.fit.windows import split

Array = npt.NDArray[np.float64]

_PIECES = 4
"""Into how many parts windows are split where their motion may be chaotic."""
_ALIKE = 1e-12
"""Directions of strengths with less than this share of the largest variance are left out."""
_COMPENSATING = 0.99
"""Correlation from which on two values compensate each other."""
_AT_LIMIT = 1e-3
"""A value at most this share of a limit away from it counts as at the limit."""


@dataclass(frozen=True)
class Attempt:
    """A refitted model, and its prediction of each fold of the windows by a fit to the others.

    The predictions are computed when they are asked for first.
    """

    fit: Fit
    folds: Folds
    predictions: Fit | None = None
    """They, where they are there already."""

    @property
    def validation(self) -> Fit:
        """The predictions.

        Raises:
            IdentificationError: they cannot be computed.
        """
        return self.predictions or self.predict()

    @property
    def is_predicted(self) -> bool:
        """Whether the predictions are there."""
        return self.predictions is not None

    def predict(self) -> Fit:
        """Compute the predictions, keep them and return them.

        Raises:
            IdentificationError: they cannot be computed.
        """
        # `validation` is no cached property: before Python 3.12 these let one thread at a time compute any of them.
        vars(self)["predictions"] = found = cross_validated(self.fit, self.folds)
        return found

    @property
    def model(self) -> MotionModel:
        """The model that was fitted."""
        return self.fit.model

    @cached_property
    def closely(self) -> Fit:
        """The model's fit to short pieces of the windows, its values held."""
        pieces = [piece for window in self.fit.windows for piece in split(window, _PIECES)]
        return refine(self.model, self.fit.values, pieces, hold_values=True)

    @cached_property
    def unknowns(self) -> float:
        """Effective number of fitted unknowns; coefficients of smooth curves count as far as they are free."""
        return effective_unknowns(self.fit)

    @cached_property
    def _covariance(self) -> Array:
        return covariance(self.fit, remembered=False)

    @cached_property
    def _information(self) -> Array:
        return curvature(self.fit)

    @property
    def compensating(self) -> list[tuple[int, int]]:
        """Which two effects have parameters that change together without changing the motion much."""
        std = np.sqrt(np.diag(self._covariance))
        with np.errstate(invalid="ignore"):
            alike = np.abs(self._covariance / np.outer(std, std)) > _COMPENSATING
        places = [self.model.places(index) for index in range(len(self.model.effects))]
        return [
            (one, other)
            for one, other in combinations(range(len(places)), 2)
            if np.any(alike[places[one], places[other]])
        ]

    @property
    def is_condensed(self) -> bool:
        """Whether it has no derivatives, and can be compared but not reported."""
        return not self.fit.sensitivities

    def condensed(self) -> "Attempt":
        """Return the same without derivatives at each sample, which of an hour take hundreds of megabytes."""
        fit, validation = (replace(of, sensitivities=()) for of in (self.fit, self.validation))
        found = replace(self, fit=fit, predictions=validation)
        kept = {"unknowns": self.unknowns, "_covariance": self._covariance, "_information": self._information}
        vars(found).update(kept)  # where cached properties are
        return found

    def place_of(self, label: str) -> int:
        """Return the index of an effect among the model's, by its label."""
        return self.model.labels.index(label)

    def strength(self, index: int) -> float:
        """Return the strength of an effect in its own standard deviations (the root of Wald's statistic).

        Its shape parameters are held, for they mean nothing where it has no strength: friction that grows with the
        bearing's load is as certain as dry friction, though lever and load make up for each other where the load hardly
        varies. Those of an effect with states of its own are not: its initial values in each window make up for them.
        """
        place, active = self.model.places(index), self.model.effects[index]
        strong = [place.start + k for k, p in enumerate(active.fitted) if not p.shape]
        shapes = [place.start + k for k, p in enumerate(active.fitted) if p.shape and not active.effect.brings_states]
        held = [k for k in shapes if np.isfinite(self._covariance[k, k])]
        spread = _conditional(self._covariance, strong, held)
        values = self.fit.values[strong]
        if not np.all(np.isfinite(spread)):
            return 0.0
        wald = float(values @ scaled_inverse(spread, _ALIKE)[0] @ values)
        return float(np.sqrt(max(wald, 0.0)))

    def variance_ratio(self, places: Sequence[int]) -> float:
        """Return how many times larger the variance of some values is than it would be with white residuals."""
        return variance_ratio(self.fit, self._covariance, self._information, places)

    def at_limit(self, index: int) -> bool:
        """Return whether an effect's fit ran into the limit of a parameter other than zero strength."""
        place = self.model.places(index)
        values = self.fit.values[place]
        for value, parameter in zip(values, self.model.effects[index].fitted, strict=True):
            for limit, inwards in ((parameter.lower, 1.0), (parameter.upper, -1.0)):
                # A limit of zero means zero strength, and limits may be infinite.
                if 0.0 < abs(limit) < np.inf and (value - limit) * inwards <= _AT_LIMIT * abs(limit):
                    return True
        return False


@dataclass(frozen=True)
class Change:
    """The change of the errors from one model to another, relative to what chance would cause."""

    fit: float
    """Fall of the squared error of the fit, over the variance of the residuals' projection on what is new, less what
    additional initial states explain by chance: chi-squared distributed where nothing is new in truth."""
    bic: float
    """Difference of Bayes's information criterion; below zero the new model is the better one."""
    freedom: float
    """Unknowns that the new model has more, 1 at least."""
    variance: float
    """Of the residuals' projection on what is new [rad^2]."""
    by_chance: float
    """Variances that additional initial states explain by chance."""
    models: tuple[Attempt, Attempt]
    """The one before, and the one after."""

    @property
    def validation(self) -> float:
        """The same fall of the predictions, by the residuals of the fit; computes them if they are not there yet."""
        before, after = self.models
        return (before.validation.squared_error - after.validation.squared_error) / self.variance - self.by_chance


def change(before: Attempt, after: Attempt) -> Change:
    """Compare two models, by the residuals that the better one leaves.

    Their variance is that of their projection on the unknowns that the better model alone has: it depends on how
    residuals and motion are correlated in time. Residuals that oscillate as the motion does count for less than white
    ones.

    Numbers that one of them has more in the initial state of each window are fitted there in cross-validation too, and
    take away one variance each by chance. In Bayes's information criterion they count with their own window's samples.
    """
    chosen, other = sorted((before, after), key=lambda attempt: attempt.fit.squared_error)
    better, names = chosen.fit, chosen.model.names
    alone = [place for place, name in enumerate(names) if name not in other.model.names]
    spread = chosen.variance_ratio(alone or range(len(names)))
    more = after.unknowns - before.unknowns
    windows = len(better.windows)
    more_states = windows * (after.model.states - before.model.states)

    variance = better.variance * spread
    independent = better.samples / spread
    return Change(
        fit=(before.fit.squared_error - after.fit.squared_error) / variance - more_states,
        bic=independent * float(np.log(after.fit.squared_error / before.fit.squared_error))
        + more * float(np.log(independent))
        + more_states * float(np.log(max(independent / windows, 1.0))),
        freedom=max(more, 1.0),
        variance=variance,
        by_chance=more_states,
        models=(before, after),
    )


def _conditional(covariance: Array, of: Sequence[int], held: Sequence[int]) -> Array:
    """Return the covariance of some values (k, k) while others are held (the Schur complement)."""
    spread, across = covariance[np.ix_(of, of)], covariance[np.ix_(of, held)]
    return spread - across @ scaled_inverse(covariance[np.ix_(held, held)], _ALIKE)[0] @ across.T
