"""A stepwise selection under way: the model that it has so far, and refits of others beside it."""

import time
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.cross_validation import Folds, cross_validated
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import JOINTS, MotionModel
from cdp_ident.fit.refinement import Fit, refine, refine_from_afar
from cdp_ident.fit.reweighting import reweighted
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.selection import Step, Tried

Array = npt.NDArray[np.float64]

_ROUGHLY = 1e-4
"""Tolerance of refits that only compare candidates; the one that is taken is refined to the end."""
_KEPT = 0.5
"""A refit over whole windows has arrived if it gains that share of what the score test promises."""
NO_STEPS: Array = np.zeros(2)
_LEAST_STEPS = 0.75
"""An angle of which an encoder is off is more than rounding from so many of its steps on; rounding is half of one."""


class InterruptedSelectionError(Exception):
    """A selection was asked to stop; what it has is in its `Progress`."""


class Progress:
    """A selection under way: the model that it has so far outlives an interruption."""

    def __init__(
        self,
        before: Attempt,
        noise: float,
        told: Callable[[str], None] = lambda line: None,
        stop: Callable[[], bool] = lambda: False,
        encoder_steps: Array = NO_STEPS,
        trying: Callable[[str], None] = lambda line: None,
    ) -> None:
        """Begin.

        Args:
            before: the paper's model.
            noise: root mean square of what the encoders add to both angles [rad].
            told: called with a line for people after each step.
            encoder_steps: of the inner and the outer encoder [rad]; what is off by less is rounding.
            stop: asked before each addition of effects; true raises `InterruptedSelectionError` there.
            trying: called with what is tried next, and how long that and what follows may take.
        """
        self.before = self.current = before
        """The model with the effects that are accepted."""
        self.noise = noise
        self.encoder_steps = encoder_steps
        self.steps: list[Step] = []
        self.rivals: dict[str, tuple[Attempt, ...]] = {}
        """The rivals that each effect has stood against in the last exchange, by its label."""
        self.failures: list[str] = []
        """What could not be computed, in words."""
        self._told, self._stop, self._trying = told, stop, trying
        self._refits, self._seconds = 0, 0.0

    def is_rounding(self, joint: str, angle: float) -> bool:
        """Return whether an angle [rad] is no more than what an encoder's steps hide while its joint stands still."""
        return abs(angle) < _LEAST_STEPS * self.encoder_steps[JOINTS.index(joint)]

    def with_effects(self, attempt: Attempt, candidates: Sequence[Candidate]) -> Attempt:
        """Return a model with more effects, refitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        model, values = attempt.model, attempt.fit.values
        for candidate in candidates:
            model = model.with_effect(candidate.active)
            values = np.concatenate([values, candidate.values])
        if self._stop():
            raise InterruptedSelectionError
        expected = attempt.fit.squared_error - sum(candidate.gain for candidate in candidates)
        return attempt_of(_refit(model, values, attempt.fit, expected), attempt.folds)

    def tried(
        self, attempt: Attempt, additions: Iterable[tuple[Candidate, ...]]
    ) -> list[tuple[tuple[Candidate, ...], Attempt]]:
        """Return a model with each of some additions, refitted; one that cannot be computed is told and left out.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        found = []
        additions = list(additions)
        for place, candidates in enumerate(additions):
            self._say_what_is_tried(candidates, place, len(additions))
            began = time.monotonic()
            try:
                found.append((candidates, self.with_effects(attempt, candidates)))
            except (IdentificationError, np.linalg.LinAlgError) as error:
                keys = " and ".join(candidate.active.effect.key for candidate in candidates)
                self.fail(f"{keys} could not be fitted: {error}")
            self._refits, self._seconds = self._refits + 1, self._seconds + time.monotonic() - began
        return found

    def _say_what_is_tried(self, candidates: Sequence[Candidate], place: int, count: int) -> None:
        keys = " and ".join(candidate.active.effect.key for candidate in candidates)
        left = f", about {self._seconds / self._refits * (count - place):.0f} s left" if self._refits else ""
        self._trying(f"trying {keys}, {place + 1} of {count}{left}")

    def replaced(self, attempt: Attempt, index: int, active: ActiveEffect, values: Array) -> list[Attempt]:
        """Return a model with another effect, of given values, in the place of one; none where it cannot be fitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        model, remain = attempt.model.without_effect(index)
        begin = np.concatenate([attempt.fit.values[remain], values])
        other = self.refitted(model.with_effect(active), begin, attempt, active.effect.key)
        return [] if other is None else [other]

    def refitted(self, model: MotionModel, values: Array, attempt: Attempt, what: str) -> Attempt | None:
        """Return another model, refitted over an attempt's windows from given values; None where it cannot be fitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        if self._stop():
            raise InterruptedSelectionError
        try:
            fit = refine(model, values, attempt.fit.windows, tolerance=_ROUGHLY)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            self.fail(f"{what} could not be fitted: {error}")
            return None
        return attempt_of(fit, attempt.folds)

    def from_balance(self, attempt: Attempt, begin: Array, candidates: Sequence[Candidate]) -> Attempt | None:
        """Return a model with more effects, refitted from what a balance of forces says of it (unknowns,) and of them.

        None where it cannot be fitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        if self._stop():
            raise InterruptedSelectionError
        model, values = attempt.model, begin
        for candidate in candidates:
            model = model.with_effect(candidate.active)
            values = np.concatenate([values, candidate.values])
        try:
            return attempt_of(refine_from_afar(model, values, attempt.fit.windows), attempt.folds)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            self.fail(f"what the balance of forces shows could not be fitted: {error}")
            return None

    def finished(self, attempt: Attempt) -> Attempt:
        """Return a model that is taken, refined to the end."""
        return attempt_of(refine(attempt.model, attempt.fit.values, attempt.fit.windows), attempt.folds)

    def reweigh(self) -> None:
        """Weigh both angles by the errors that the model leaves, which are other ones than before its last effects."""
        try:
            fit = reweighted(self.current.fit, self.noise)
            if fit is not self.current.fit:
                self.current = attempt_of(fit, self.current.folds)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            self.fail(f"the angles keep their weights: {error}")

    def fail(self, line: str) -> None:
        """Note what could not be computed, and tell people."""
        self.failures.append(line)
        self._told(line)

    def say(self, line: str) -> None:
        """Tell people a line."""
        self._told(line)

    def note(self, action: str, after: Attempt, line: str, tried: Sequence[Tried] = ()) -> None:
        """Note a step that ended with the model `after`, and tell people a line about it."""
        self.steps.append(Step(action, after.fit.rmse(), after.validation.rmse(), tuple(tried)))
        self._told(line)


def without_effects(attempt: Attempt, indices: Sequence[int]) -> Attempt:
    """Return a model without some of its effects, refitted."""
    model: MotionModel = attempt.model
    values: Array = attempt.fit.values
    for index in sorted(indices, reverse=True):
        model, remain = model.without_effect(index)
        values = values[remain]
    return attempt_of(refine(model, values, attempt.fit.windows), attempt.folds)


def _refit(model: MotionModel, values: Array, before: Fit, expected: float) -> Fit:
    """Refine a model with more effects, over whole windows at once or, where that does not do, over growing ones.

    Args:
        model: the model.
        values: (unknowns,) values to begin with.
        before: the fit of the model without them.
        expected: the squared error that score tests promise [rad^2].
    """
    at_once: Fit | None = None
    try:
        at_once = refine(model, values, before.windows, tolerance=_ROUGHLY)
    except IdentificationError:
        pass  # the motion cannot be computed over whole windows; over short ones it can
    else:
        if at_once.converged and before.squared_error - at_once.squared_error > _KEPT * (
            before.squared_error - expected
        ):
            return at_once
    grown = refine_from_afar(model, values, before.windows, tolerance=_ROUGHLY)
    return at_once if at_once is not None and at_once.squared_error < grown.squared_error else grown


def attempt_of(fit: Fit, folds: Folds) -> Attempt:
    """Return a fitted model with its predictions of each fold."""
    return Attempt(fit, cross_validated(fit, folds), folds)
