"""The outcome of a stepwise selection of effects: the chosen model, and the steps that led to it."""

from dataclasses import dataclass, replace
from typing import Literal

from cdp_ident.tracing.evidence import Attempt

Certainty = Literal["named", "probable", "acts_like"]
"""How sure an effect's name is."""


@dataclass(frozen=True)
class Tried:
    """A candidate that was refitted at a step."""

    effects: tuple[str, ...]
    """Keys of the effect or, where two only help together, the two."""
    rmse_fit: float
    """[rad]"""
    rmse_validation: float
    """[rad]; not a number where the fit alone ruled it out."""
    gain: float
    """Fall of the squared error of the fit [variances]; see `Change.fit`."""
    freedom: float
    """Unknowns that it added."""
    delta_bic: float
    """Difference of Bayes's information criterion from the model before."""


@dataclass(frozen=True)
class Step:
    """One step of the selection."""

    action: str
    """What was done: added, dropped or exchanged, and what."""
    rmse_fit: float
    """Error of the fit after it [rad]."""
    rmse_validation: float
    """Validation error after it [rad]."""
    tried: tuple[Tried, ...]


@dataclass(frozen=True)
class Selection:
    """Where a selection ended."""

    before: Attempt
    """The paper's model."""
    after: Attempt
    """The model with the effects."""
    steps: tuple[Step, ...]
    without: tuple[Attempt, ...]
    """That model without each of its effects."""
    also_possible: tuple[tuple[str, ...], ...]
    """Keys of the effects that the data do not distinguish from each one."""
    certainty: tuple[Certainty, ...]
    """How sure the name of each effect of `after` is."""
    failures: tuple[str, ...]
    """What could not be computed, in words."""
    interrupted: bool
    looked_in: int
    """In how many of the windows effects were looked for."""

    def withdrawn(self) -> "Selection":
        """Return the same without its effects: it ends where it began."""
        return replace(self, after=self.before, without=(), also_possible=(), certainty=())

    @classmethod
    def nothing(cls, model: Attempt) -> "Selection":
        """Return one without any step."""
        return cls(model, model, (), (), (), (), (), interrupted=False, looked_in=len(model.fit.windows))
