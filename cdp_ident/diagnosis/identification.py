# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted model with its diagnosis: physical values, A22, and whether each trial alone says the same."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import chdtrc

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.physical import PhysicalValues, nearest_physical_values
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import ENOUGH_STEPS
from cdp_ident.likelihood.reduction import information_of
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, inertia_about_cart
from cdp_ident.search.genetic_search import SearchResult

GUESSED = 0.5
"""Relative standard deviation from which on a value is as good as guessed."""


@dataclass(frozen=True)
class Inertia:
    """A22, the inertia about the cart's joint, relative to which a free swing determines all parameters."""

    value: float
    """[kg m^2]"""
    relative_std: float
    covariance: Array
    """(unknowns,) covariance of its logarithm with each unknown of the model."""
    shown: bool
    """Whether weights or motors show it; if not, it is that of the nearest physical values."""

    @property
    def std(self) -> float:
        """Standard deviation [kg m^2]."""
        return self.value * self.relative_std


@dataclass(frozen=True)
class Repeatability:
    """Each trial's own estimate beside the joint one."""

    trials: tuple[str, ...]
    names: tuple[str, ...]
    """Of the unknowns that are compared: not 1 / A22, which no trial shows alone."""
    values: Array
    """(trials, unknowns) each trial's own estimate."""
    std: Array
    """(trials, unknowns) its standard deviations."""
    p_value: float
    """Probability that estimates scatter at least so much if all trials have the same parameters."""

    @property
    def agree(self) -> bool:
        """Whether the trials agree, at a level of 1 %."""
        return self.p_value > 0.01


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
        return cls(
            options, data, search, whole, fit, covariance, *_in_physical_units(options, fit, covariance), failure
        )

    def with_covariance(self, spread: Array) -> "Identification":
        """Return it with another covariance (unknowns, unknowns) of the fitted values, and what follows from that."""
        physical, inertia = _in_physical_units(self.options, self.fit, spread)
        return replace(self, covariance=spread, physical=physical, inertia=inertia)

    @property
    def enough(self) -> float:
        """Motion in which effects are looked for, where there is more [s]: what the user asks for, or what suffices."""
        return self.options.motion_for_effects or self.data.scales.enough

    @cached_property
    def _each_alone(self) -> tuple[Repeatability | None, tuple[str, ...]]:
        try:
            return repeatability(self.whole, {window.trial for window in self.data.fit}, self.data.names), ()
        except (IdentificationError, np.linalg.LinAlgError) as error:
            return None, (f"each trial alone: {error}",)

    @property
    def repeatability(self) -> Repeatability | None:
        """Each trial's own estimate beside the joint one; None with one trial, or where it could not be computed."""
        return self._each_alone[0]

    @property
    def failures(self) -> tuple[str, ...]:
        """What of the diagnosis could not be computed, in words."""
        return self._each_alone[1]

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


def _in_physical_units(options: IdentifyOptions, fit: Fit, spread: Array) -> tuple[PhysicalValues, Inertia]:
    """Return the physical values nearest to the nominal ones, and A22: as trials show it, or of these values."""
    model, values = fit.model, fit.values
    inverse, (length, _) = model.inverse_inertia(values), model.constants(values)
    shown = list(range(len(GROUPS)))
    is_shown = model.inertia_free and inverse > 0.0
    if is_shown:
        shown.append(model.names.index(INVERSE_INERTIA.symbol))
    covariance = spread[np.ix_(shown, shown)]
    if is_shown and model.motors:
        # All torques may be larger or smaller than they are recorded.
        covariance[-1, -1] += (model.torque_std * inverse) ** 2
    physical = nearest_physical_values(values[shown], covariance, options.prior, length)
    if is_shown:
        relative_std = float(np.sqrt(covariance[-1, -1])) / inverse
        return physical, Inertia(1.0 / inverse, relative_std, -spread[:, shown[-1]] / inverse, True)
    value = float(inertia_about_cart(physical.values, length))
    return physical, Inertia(value, physical.inertia_relative_std, np.zeros(len(values)), False)


def repeatability(found: WholeSwings, trials: Collection[int], names: Sequence[str]) -> Repeatability | None:
    """Fit each of some trials alone, beginning from the joint fit; None where only one of them was fitted.

    The estimates are compared by their weighted sum of squares about their weighted mean, which is chi-squared
    distributed if they agree. A22, where weights show it, is that of the joint fit: by it the estimates of a trial with
    weights are those of the rig without. `names` are those of all trials. Raises `IdentificationError` where a trial
    alone cannot be fitted.
    """
    swings = found.recorded.swings
    indices = sorted({swing.trial for swing in swings} & set(trials))
    if len(indices) < 2:
        return None
    model, remain = found.model.with_inertia_known(found.values)
    noise, values, covariances = replace(found.noise, tails=()), [], []
    for index in indices:
        places = [k for k, swing in enumerate(swings) if swing.trial == index]
        recorded = replace(found.recorded, swings=tuple(swings[k] for k in places))
        states = [found.states[k] for k in places]
        alone = GaussNewton(model, found.values[remain], recorded, states, noise).run(ENOUGH_STEPS).found()
        values.append(alone.values)
        covariances.append(alone.covariance)
    std = np.sqrt([np.diag(spread) for spread in covariances])
    # Coefficients of curves would agree in any case, as they are smooth; what happens once is of one trial.
    seen = np.all(np.isfinite(std) & (std > 0), axis=0) & model.of_rig & ~model.of_curves
    for index, active in enumerate(model.effects):
        seen[model.places(index)] &= active.trial is None
    inverses = [information_of(spread[np.ix_(seen, seen)]) for spread in covariances]
    estimates = np.array(values)[:, seen]
    mean = information_of(np.sum(inverses, axis=0)) @ np.einsum("tij,tj->i", inverses, estimates)
    scatter = np.einsum("ti,tij,tj->", estimates - mean, inverses, estimates - mean)
    # The common A22 was chosen so that they agree.
    freedom = (len(indices) - 1) * int(seen.sum()) - int(found.model.inertia_free)
    return Repeatability(
        trials=tuple(names[index] for index in indices),
        names=model.names,
        values=np.array(values),
        std=std,
        p_value=float(chdtrc(freedom, scatter)) if freedom > 0 else 1.0,
    )
