# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted model with its diagnosis."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.inertia import Inertia
from cdp_ident.diagnosis.repeatability import Repeatability, repeatability
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.physical import PhysicalValues, nearest_physical_values
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA
from cdp_ident.search.genetic_search import SearchResult

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Identification:
    """The paper's model identified from trials."""

    options: IdentifyOptions
    data: Data
    search: SearchResult
    """The paper's search, from whose best chromosome the fit begins."""
    whole: WholeSwings
    """The model's most likely values given whole swings."""
    fit: Fit
    """The motion over windows under the values that are given."""
    covariance: Array
    """(unknowns, unknowns) covariance of these."""
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
        search: SearchResult,
        whole: WholeSwings,
        fit: Fit,
        covariance: Array,
        failure: str = "",
    ) -> "Identification":
        """Diagnose a fitted model; see the fields."""
        physical, compared, failures = _physical(options, fit, covariance), None, tuple[str, ...]()
        try:
            compared = repeatability(whole, {window.trial for window in data.fit}, data.names)
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures = (f"each trial alone: {error}",)
        return cls(
            options=options,
            data=data,
            search=search,
            whole=whole,
            fit=fit,
            covariance=covariance,
            physical=physical,
            inertia=Inertia.of(fit.model, fit.values, covariance, physical),
            failure=failure,
            repeatability=compared,
            failures=failures,
        )

    def with_covariance(self, spread: Array) -> "Identification":
        """Return it with another covariance (unknowns, unknowns) of the fitted values, and what follows from that."""
        physical = _physical(self.options, self.fit, spread)
        inertia = Inertia.of(self.fit.model, self.fit.values, spread, physical)
        return replace(self, covariance=spread, physical=physical, inertia=inertia)

    @property
    def enough(self) -> float:
        """Motion in which effects are looked for, where there is more [s]: what the user asks for, or what suffices."""
        return self.options.motion_for_effects or self.data.scales.enough

    @cached_property
    def length_by_motion(self) -> tuple[float, float]:
        """L as motion alone shows it, nothing being known of it beforehand, and its standard deviation [m]."""
        whole = self.whole
        if not whole.model.length_std:
            model = replace(whole.model, length_std=np.inf)
            values = np.insert(whole.values, len(GROUPS), model.mechanism.length)
            try:
                whole = GaussNewton(model, values, whole.recorded, whole.states, whole.noise).run().found()
            except (IdentificationError, np.linalg.LinAlgError):
                return model.mechanism.length, np.inf
        place = whole.model.names.index("L")
        return float(whole.values[place]), float(np.sqrt(whole.covariance[place, place]))

    @property
    def interrupted(self) -> bool:
        """Whether the search was ended early."""
        return not self.search.completed


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
