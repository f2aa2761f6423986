"""A fitted model with its diagnosis."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.inertia import Inertia
from cdp_ident.diagnosis.length import LengthByBalance
from cdp_ident.diagnosis.repeatability import Repeatability, repeatability
from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.estimation import Estimate
from cdp_ident.fit.force_balance import ForceBalance
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.physical import PhysicalValues, nearest_physical_values
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA

Array = npt.NDArray[np.float64]
Result = TypeVar("Result")


@dataclass(frozen=True)
class Identification:
    """The paper's model identified from trials."""

    options: IdentifyOptions
    data: Data
    balances: tuple[ForceBalance, ...]
    """Balances of forces of the trials, the most likely first; none where there is too little motion."""
    length: LengthByBalance | None
    """L by the balance of forces, where it differs clearly from the given one."""
    estimate: Estimate
    covariance: Array
    """(unknowns, unknowns) covariance of the fitted values."""
    physical: PhysicalValues
    inertia: Inertia
    failure: str
    """Why no parameter means anything, in words; empty where the fit did not fail."""
    repeatability: Repeatability | None
    failures: tuple[str, ...] = ()
    """What of the diagnosis could not be computed, in words."""

    @classmethod
    def of(
        cls,
        options: IdentifyOptions,
        data: Data,
        balances: tuple[ForceBalance, ...],
        length_by_balance: LengthByBalance | None,
        estimate: Estimate,
        failure: str = "",
    ) -> "Identification":
        """Diagnose an estimate."""
        fit, failures = estimate.fit, list[str]()
        spread = _if_possible("how sure the values are", lambda: covariance(fit), failures)
        if spread is None:  # then none of them is
            spread = np.diag(np.full(len(fit.values), np.inf))
        physical = _physical(options, fit, spread)
        return cls(
            options=options,
            data=data,
            balances=balances,
            length=length_by_balance,
            estimate=estimate,
            covariance=spread,
            physical=physical,
            inertia=Inertia.of(fit.model, fit.values, spread, physical),
            failure=failure,
            repeatability=_if_possible("each trial alone", lambda: repeatability(fit, data.names), failures),
            failures=tuple(failures),
        )

    def with_covariance(self, spread: Array) -> "Identification":
        """Return it with another covariance (unknowns, unknowns) of the fitted values, and what follows from that."""
        physical = _physical(self.options, self.fit, spread)
        inertia = Inertia.of(self.fit.model, self.fit.values, spread, physical)
        return replace(self, covariance=spread, physical=physical, inertia=inertia)

    @property
    def fit(self) -> Fit:
        """The refined fit."""
        return self.estimate.fit

    @property
    def enough(self) -> float:
        """Motion in which effects are looked for, where there is more [s]: what the user asks for, or what suffices."""
        return self.options.motion_for_effects or self.data.scales.enough

    @property
    def interrupted(self) -> bool:
        """Whether the search was ended early."""
        return not self.estimate.search.completed


def _if_possible(what: str, compute: Callable[[], Result | None], failures: list[str]) -> Result | None:
    """Return what is computed, or nothing where that fails; then why is added to the failures."""
    try:
        return compute()
    except (IdentificationError, np.linalg.LinAlgError) as error:
        failures.append(f"{what}: {error}")
        return None


def _physical(options: IdentifyOptions, fit: Fit, spread: Array) -> PhysicalValues:
    length, _ = fit.model.constants(fit.values)
    shown = list(range(len(GROUPS)))
    if fit.model.inertia_free and fit.model.inverse_inertia(fit.values) > 0.0:
        shown.append(fit.model.names.index(INVERSE_INERTIA.symbol))
    covariance = spread[np.ix_(shown, shown)]
    if fit.model.motors:
        # All torques may be larger or smaller than they are recorded.
        covariance[-1, -1] += (fit.model.torque_std * fit.values[shown[-1]]) ** 2
    return nearest_physical_values(fit.values[shown], covariance, options.prior, length)
