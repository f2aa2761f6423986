"""The progress of a stepwise selection: the present model, and refits of others."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.astray import with_starts_found_again
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.noise import NO_STEPS
from cdp_ident.fit.refinement import refine, refine_from_afar
from cdp_ident.fit.reweighting import reweighted
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.refits import (
    Condition,
    always,
    attempt_of,
    left_after,
    predicted,
    refit_with,
    refit_without,
    roughly,
    tolerance_of,
    with_candidates,
)
from cdp_ident.tracing.selection import Step, Tried

Array = npt.NDArray[np.float64]
Begun = TypeVar("Begun")


class InterruptedSelectionError(Exception):
    """A selection was asked to stop; what it has is in its `Progress`."""


class Progress:
    """A selection in progress; its model so far is kept when the selection is interrupted."""

    def __init__(
        self,
        before: Attempt,
        noise: float,
        say: Callable[[str], None] = lambda line: None,
        stop: Callable[[], bool] = lambda: False,
        encoder_steps: Array = NO_STEPS,
        trying: Callable[[str], None] = lambda line: None,
    ) -> None:
        """Begin.

        Args:
            before: the paper's model.
            noise: root mean square of what the encoders add to both angles [rad].
            say: called with a line of text after each step.
            encoder_steps: of the inner and the outer encoder [rad]; an offset below is rounding.
            stop: asked before each addition of effects; true raises `InterruptedSelectionError` there.
            trying: called with what is tried next, and how long that and what follows may take.
        """
        self.before = self.current = before
        """The model with the effects that are accepted."""
        self.noise = noise
        self.encoder_steps = encoder_steps
        self.steps: list[Step] = []
        self.rivals: dict[str, tuple[Attempt, ...]] = {}
        """The rivals that each effect was compared with in the last exchange, by its label."""
        self.failures: list[str] = []
        """What could not be computed, in words."""
        self._say, self._stop, self._trying = say, stop, trying
        self._refits, self._seconds = 0, 0.0
        self._whole: Attempt | None = None
        self._without: dict[tuple[int, ...], Attempt] = {}
        """Refits of one model without some of its effects, by their indices."""
        self._compared_in, self._compared = before, set[tuple[str, ...]]()
        self._condenses = False
        """Whether these are kept without derivatives."""

    def is_rounding(self, joint: str, angle: float) -> bool:
        """Return whether an angle [rad] may be the rounding of an encoder whose joint is at rest."""
        return abs(angle) < thresholds.LEAST_STEPS * self.encoder_steps[JOINTS.index(joint)]

    def go_on(self) -> None:
        """Raise InterruptedSelectionError if the selection is asked to stop."""
        if self._stop():
            raise InterruptedSelectionError

    def compared_in(self, model: Attempt) -> set[tuple[str, ...]]:
        """Return the labels of the effects, alone or together, that were compared with their rivals in a model.

        The set is the caller's to add to; it is kept for the model that was asked for last.
        """
        if self._compared_in is not model:
            self._compared_in, self._compared = model, set()
        return self._compared

    def tried(
        self,
        attempt: Attempt,
        additions: Iterable[tuple[Candidate, ...]],
        to_beat: Attempt | None = None,
        may_win: Condition = always,
    ) -> list[tuple[tuple[Candidate, ...], Attempt]]:
        """Return refits of a model with each of some additions; those that fail are reported and left out.

        So are, without a report, those whose squared error is far above the one that they are to beat.

        Args:
            attempt: the model.
            additions: what is added to it, each time.
            to_beat: a model that they are to beat.
            may_win: which of them are predicted: the others are compared by their fits alone.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        with_each = [(attempt, added) for added in additions]
        return [(added, after) for _, added, after in self.tried_on(with_each, to_beat, may_win)]

    def tried_on(
        self,
        additions: Sequence[tuple[Attempt, tuple[Candidate, ...]]],
        to_beat: Attempt | None = None,
        may_win: Condition = always,
    ) -> list[tuple[Attempt, tuple[Candidate, ...], Attempt]]:
        """Return models, what is added to each, and the refit with it; the rest is as in `tried`.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """

        def refit(addition: tuple[Attempt, tuple[Candidate, ...]]) -> Attempt | None:
            attempt, candidates = addition
            model, values = with_candidates(attempt.model, attempt.fit.values, candidates)
            expected = attempt.fit.squared_error - sum(candidate.gain for candidate in candidates)
            return predicted(refit_with(model, values, attempt.fit, expected), attempt.folds, to_beat, may_win)

        names = [" and ".join(candidate.active.effect.key for candidate in added) for _, added in additions]
        found = self._refitted(refit, additions, names)
        return [(*addition, after) for addition, after in zip(additions, found, strict=True) if after]

    def replaced(
        self,
        attempt: Attempt,
        indices: Sequence[int],
        others: Sequence[tuple[ActiveEffect, Array]],
        to_beat: Attempt | None = None,
        may_win: Condition = always,
        from_afar: bool = False,
    ) -> list[Attempt]:
        """Return models with each of other effects, of given values, in the place of some.

        What is left out, and what is not predicted, is as in `tried`. On request they are fitted over windows of
        growing length, for values that may be far from those that fit.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        model, remaining = left_after(attempt, indices)
        begun = [(model.with_effect(active), np.concatenate([remaining, values])) for active, values in others]
        found = self._refitted(
            roughly(attempt, to_beat, may_win, from_afar), begun, [active.effect.key for active, _ in others]
        )
        return [after for after in found if after]

    def reduced(self, leaving_out: Sequence[tuple[Attempt, int]], may_win: Condition = always) -> list[Attempt | None]:
        """Return models without one of their effects each, refitted from the values of the others; None as in `tried`.

        Args:
            leaving_out: the models, and the index of the effect that each is left without.
            may_win: which of the refits are predicted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """

        def refit(of: tuple[Attempt, int]) -> Attempt | None:
            attempt, index = of
            return roughly(attempt, may_win=may_win)(left_after(attempt, [index]))

        names = [" and ".join(left_after(attempt, [index])[0].labels) for attempt, index in leaving_out]
        return self._refitted(refit, leaving_out, names)

    def enriched(self, attempt: Attempt, index: int, richer: Candidate) -> list[Attempt]:
        """Return a model with an effect that contains the one in whose place it is; none where it cannot be fitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        model, values = with_candidates(*left_after(attempt, [index]), [richer])
        expected = attempt.fit.squared_error - richer.gain

        def refit(begun: Array) -> Attempt:
            return attempt_of(refit_with(model, begun, attempt.fit, expected), attempt.folds)

        return [after for after in self._refitted(refit, [values], [richer.active.effect.key]) if after]

    def refitted(self, model: MotionModel, values: Array, attempt: Attempt, what: str) -> Attempt | None:
        """Return another model, refitted over an attempt's windows from given values; None where it cannot be fitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        return self._refitted(roughly(attempt), [(model, values)], [what])[0]

    def without(self, attempt: Attempt, indices: Sequence[int]) -> Attempt:
        """Return a model without some of its effects, refitted; see `without_each`."""
        return self.without_each(attempt, [indices])[0]

    def without_each(self, attempt: Attempt, leaving_out: Sequence[Sequence[int]]) -> list[Attempt]:
        """Return a model without some of its effects, refitted, for each choice of those that are left out.

        What was computed for the model that was asked for last is not computed again. The paper's model stands for one
        that cannot be fitted, which is reported: then the effects are needed.
        """
        if self._whole is not attempt:
            self._whole, self._without = attempt, {}
        new = [chosen for chosen in dict.fromkeys(map(tuple, leaving_out)) if chosen not in self._without]

        def refit(indices: Sequence[int]) -> Attempt | Exception:
            after = refit_without(attempt, indices)
            return after.condensed() if self._condenses and isinstance(after, Attempt) else after

        # Side by side, the derivatives of all windows of several models would not fit into memory.
        for chosen, after in zip(new, (map if self._condenses else parallel_map)(refit, new), strict=True):
            if isinstance(after, Exception):
                names = " and ".join(attempt.model.labels[index] for index in chosen)
                self.fail(f"the model without {names} could not be fitted, it is compared with the paper's: {after}")
            self._without[chosen] = self.before if isinstance(after, Exception) else after
        return [self._without[tuple(chosen)] for chosen in leaving_out]

    def aside(self, stop: Callable[[], bool]) -> "Progress":
        """Return the progress of the same model, for another thread: what fails there it does not report, but has.

        It is also stopped by `stop`.
        """
        return Progress(
            self.current,
            self.noise,
            stop=lambda: self._stop() or stop(),
            encoder_steps=self.encoder_steps,
            trying=self._trying,
        )

    def over(self, before: Attempt) -> "Progress":
        """Return the progress of the same selection over more windows, which begins with the paper's model there.

        Models without some of its effects are condensed there.
        """
        other = Progress(before, self.noise, self._say, self._stop, self.encoder_steps, self._trying)
        other.steps, other.failures, other._condenses = self.steps, self.failures, True
        return other

    def adopted(self, found: Attempt) -> Attempt:
        """Return a model that was found over other windows, refined over those of the present model.

        Raises:
            IdentificationError: it cannot be fitted.
        """
        fit, white = self.current.fit, found.fit.windows[0].whitening
        model, values = found.model, found.fit.values
        if model.zeros:
            model, values = model.with_zeros(values, {window.trial for window in fit.windows})
        before = replace(fit, windows=tuple(replace(window, whitening=white) for window in fit.windows))
        expected = found.fit.variance * fit.samples
        return self.finished(Attempt(refit_with(model, values, before, expected), self.current.folds))

    def _refitted(
        self, refit: Callable[[Begun], Attempt | None], begun: Sequence[Begun], names: Sequence[str]
    ) -> list[Attempt | None]:
        """Return refits, as many at a time as there are cores; None for those that fail, which are reported."""

        def outcome(begin: Begun) -> Attempt | Exception | None:
            self.go_on()
            try:
                return refit(begin)
            except (IdentificationError, np.linalg.LinAlgError) as error:
                return error

        found: list[Attempt | None] = []
        outcomes = parallel_map(outcome, begun)
        for place, name in enumerate(names):
            self._say_what_is_tried(name, len(names) - place, len(names))
            began = time.monotonic()
            after = next(outcomes)
            self._refits, self._seconds = self._refits + 1, self._seconds + time.monotonic() - began
            if isinstance(after, Exception):
                self.fail(f"{name} could not be fitted: {after}")
            found.append(None if isinstance(after, Exception) else after)
        return found

    def _say_what_is_tried(self, name: str, left: int, count: int) -> None:
        seconds = f", about {self._seconds / self._refits * left:.0f} s left" if self._refits else ""
        self._trying(f"trying {name}, {count - left + 1} of {count}{seconds}")

    def from_balance(self, attempt: Attempt, begin: Array, candidates: Sequence[Candidate]) -> Attempt | None:
        """Return a model with more effects, refitted from the values of a balance of forces (unknowns,).

        None where it cannot be fitted.

        Raises:
            InterruptedSelectionError: the selection is asked to stop.
        """
        self.go_on()
        model, values = with_candidates(attempt.model, begin, candidates)
        try:
            fit = refine_from_afar(model, values, attempt.fit.windows, tolerance=tolerance_of(attempt.fit))
            return attempt_of(with_starts_found_again(fit), attempt.folds)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            self.fail(f"what the balance of forces shows could not be fitted: {error}")
            return None

    def finished(self, attempt: Attempt) -> Attempt:
        """Return an accepted model, refined to convergence; as it is where that cannot be done."""
        try:
            fit = refine(attempt.model, attempt.fit.values, attempt.fit.windows)
            return attempt_of(with_starts_found_again(fit), attempt.folds)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            if attempt.is_condensed:
                raise
            self.fail(f"the fit with {' and '.join(attempt.model.labels)} is not refined further: {error}")
            return attempt

    def reweigh(self) -> None:
        """Weight both angles by the present model's errors."""
        try:
            fit = reweighted(self.current.fit, self.noise)
            if fit is not self.current.fit:
                self.current = attempt_of(fit, self.current.folds)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            self.fail(f"the angles keep their weights: {error}")

    def fail(self, line: str) -> None:
        """Record what could not be computed, and report it."""
        self.failures.append(line)
        self._say(line)

    def say(self, line: str) -> None:
        """Report a line of text."""
        self._say(line)

    def note(self, action: str, after: Attempt, line: str, tried: Sequence[Tried] = ()) -> None:
        """Record a step that ended with the model `after`, and report a line about it."""
        self.steps.append(Step(action, after.fit.rmse(), after.validation.rmse(), tuple(tried)))
        self._say(line)
