# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a rig before its next trial."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.reduction import inverse_of
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import INVERSE_INERTIA
from cdp_ident.model.weights import Weight

NEW = -1
"""Number of the next trial, in which nothing happens once."""
_ROUNDING = 1e-14
"""Variance of a combination of scaled values, over the largest, that is rounding."""


@dataclass(frozen=True)
class Sampling:
    """How the next trial is recorded, and its nodes are laid: as those before it were."""

    duration: float
    """Of the trial [s]."""
    interval: float
    """Between samples [s]."""
    spacing: float
    """Of the nodes [s]."""
    step: float
    """Of the integrator [s]."""
    steps: Array
    """(2,) of the encoders, 0 where none shows [rad]."""


class Uncertainty(NamedTuple):
    """Of one unknown, or of several together, what is not asked for being estimated along with them.

    The trial that makes the first smallest is c-optimal, the second D-optimal: it has the smallest determinant of the
    covariance, that is volume of the confidence region (Pukelsheim, Optimal Design of Experiments, 1993, Chapters 2 and
    6; Atkinson, Donev and Tobias, Optimum Experimental Designs, with SAS, 2007, Chapters 10 and 11).
    """

    std: Array
    """(names,) standard deviations."""
    size: float
    """How uncertain they are together: the root of the determinant's root of as many; one's own deviation."""


@dataclass(frozen=True)
class Knowledge:
    """A fitted model, how sure its values are, and how a further trial would be measured."""

    model: MotionModel
    """The model; where each trial's encoders have zeros of their own, the next trial's are among its unknowns."""
    values: Array
    """(unknowns,) the fitted values; those of zeros and errors of weights that are not known yet are 0."""
    covariance: Array
    """(unknowns, unknowns) of them; infinite for what nothing is known of."""
    noise: Noise
    """Of encoders and unknown torques."""
    sampling: Sampling

    @classmethod
    def of(cls, whole: WholeSwings, values: Array, covariance: Array, inertia: float) -> "Knowledge":
        """Take it from the fit of a model.

        Args:
            whole: the model, given the swings that there are.
            values: (unknowns,) its values.
            covariance: (unknowns, unknowns) of these.
            inertia: A22 [kg m^2], as good as it is known where no trial shows it.
        """
        swings, ends = whole.recorded.swings, dict[int, float]()
        for swing in swings:
            ends[swing.trial] = max(ends.get(swing.trial, 0.0), swing.begin + float(swing.time[-1]))
        sampling = Sampling(
            duration=float(np.median(list(ends.values()))),
            interval=float(np.median(np.concatenate([np.diff(swing.time) for swing in swings]))),
            spacing=swings[0].spacing,
            step=float(swings[0].times.step[0]),
            steps=whole.recorded.steps,
        )
        torque = whole.noise.torque_with_tails
        noise = replace(whole.noise, torque=torque, of_base=whole.base_moves, tails=())
        mechanism = replace(whole.model.mechanism, inertia=inertia)
        model, remain = replace(whole.model, mechanism=mechanism, zeros=()), ~whole.model.of_zeros
        found = cls(model, values[remain], covariance[np.ix_(remain, remain)], noise, sampling)
        return found.with_weights(()).with_zeros_of_its_own(whole.model.zero_joints if whole.model.zeros else ())

    def with_weights(self, weights: Iterable[Weight]) -> "Knowledge":
        """Return it with A22, and what weights of a next trial may be wrong by, among the unknowns.

        Of A22 nothing is known where no trial shows it; a weight's error is known to be within its standard deviation.
        """
        model, known = self.model, self.model.weight_errors
        more = tuple(dict.fromkeys(e for weight in weights for e in weight.errors if e not in known))
        first = len(model.base_names) - len(known)  # 1 / A22 is before the errors of weights, which end the base
        inverse = () if model.inertia_free else (1.0 / model.mechanism.inertia,)
        places = [first] * len(inverse) + [first + len(known)] * len(more)
        values = np.insert(self.values, places, [*inverse, *(0.0 for _ in more)])
        variances = np.insert(np.zeros(len(self.values)), places, [*(np.inf for _ in inverse), *(1.0 for _ in more)])
        model = replace(model, inertia_free=True, weight_errors=(*known, *more))
        return self._extended(model, values, variances)

    def with_zeros_of_its_own(self, joints: tuple[str, ...]) -> "Knowledge":
        """Return it with zeros of the next trial's encoders in some joints among the unknowns."""
        if not joints:
            return self
        model, values = replace(self.model, zero_joints=joints).with_zeros(self.values, [NEW])
        return self._extended(model, values, np.full(len(values), np.inf))

    def _extended(self, model: MotionModel, values: Array, variances: Array) -> "Knowledge":
        """Return it with a model that has more unknowns; of variances (unknowns,) those of the new ones count."""
        own = np.isin(model.names, self.model.names)
        spread = np.diag(variances)
        spread[np.ix_(own, own)] = self.covariance
        return replace(self, model=model, values=values, covariance=spread)

    @property
    def shows_inertia(self) -> bool:
        """Whether the trials that there are show A22."""
        (place,) = self.places([INVERSE_INERTIA.symbol])
        return bool(np.isfinite(self.covariance[place, place]))

    @property
    def asked(self) -> tuple[str, ...]:
        """Names of the unknowns that a user may ask for: the rig's, but for coefficients of curves."""
        may = self.model.of_rig & ~self.model.of_curves
        return tuple(name for name, may_be in zip(self.model.names, may, strict=True) if may_be)

    def places(self, names: Sequence[str]) -> Indices:
        """Return where unknowns are, by their names."""
        return np.array([self.model.names.index(name) for name in names], dtype=np.int64)

    @cached_property
    def rows(self) -> Array:
        """(k, unknowns) rows whose products are the inverse of the covariance, as far as something is known."""
        seen = np.flatnonzero(np.isfinite(np.diag(self.covariance)) & (np.diag(self.covariance) > 0.0))
        std = np.sqrt(np.diag(self.covariance)[seen])
        sizes, vectors = np.linalg.eigh(self.covariance[np.ix_(seen, seen)] / np.outer(std, std))
        rows = np.zeros((len(seen), len(self.values)))
        rows[:, seen] = (vectors / np.sqrt(np.maximum(sizes, _ROUNDING * sizes[-1]))).T / std
        return rows

    def uncertainty(self, names: Sequence[str], gained: Array | None = None) -> Uncertainty:
        """Return that of the unknowns of these names, with rows (n, unknowns) of a further trial's information."""
        asked = self.places(names)
        rows = self.rows if gained is None else np.concatenate([self.rows, gained])
        part = covariance_of(rows)[np.ix_(asked, asked)]
        std = np.sqrt(np.diag(part))
        if not np.all(np.isfinite(part)):
            return Uncertainty(std, float("inf"))
        scale = np.maximum(std, np.sqrt(np.finfo(float).tiny))
        sign, logarithm = np.linalg.slogdet(part / np.outer(scale, scale))
        together = float(np.exp(np.mean(np.log(scale))))
        return Uncertainty(std, together * float(np.exp(logarithm / (2 * len(asked)))) if sign > 0 else 0.0)


def covariance_of(rows: Array) -> Array:
    """Return the covariance (k, k) of all unknowns, given rows (n, k); infinite for one of which they say nothing."""
    _, covariance, undetermined = inverse_of(rows)
    covariance[undetermined, undetermined] = np.inf
    return covariance
