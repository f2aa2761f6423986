"""What is known of a rig before its next trial."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.design.information import scaled_inverse
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.scales import Scales
from cdp_ident.model.parameters import INVERSE_INERTIA
from cdp_ident.model.weights import Weight

Array = npt.NDArray[np.float64]

NEW = -1
"""Number of the next trial, in which nothing happens once."""
_UNOBSERVABLE = 1e-14


@dataclass(frozen=True)
class Sampling:
    """How the next trial is recorded and fitted: as those before it were."""

    duration: float
    """Of the trial [s]."""
    interval: float
    """Between samples that are fitted [s]."""
    window: float
    """Length of the windows that it is cut into [s]; 0 for as long as the motion can be followed."""
    shortest_window: float
    """They are not shorter [s]."""
    half_width: float
    """Of the local cubics that estimate the windows' initial states, at most [s]: less where the motion is livelier."""
    step: float
    """Of the integrator [s]."""
    noise: Array
    """(2,) standard deviation of the noise of theta1 and theta2, by which windows are as long as they are [rad]. What
    a model leaves of the motion beyond that makes its values less sure, and no window shorter."""


@dataclass(frozen=True)
class Knowledge:
    """A fitted model, how sure its values are, and how a further trial would be measured."""

    model: MotionModel
    """The model; where each trial's encoders have zeros of their own, the next trial's are among its unknowns."""
    values: Array
    """(unknowns,) the fitted values; those of zeros and errors of weights that are not known yet are 0."""
    covariance: Array
    """(unknowns, unknowns) of them; infinite for what nothing is known of."""
    noise: float
    """Standard deviation of a reading of an encoder, were all readings independent [rad]."""
    sampling: Sampling

    @classmethod
    def of(
        cls, fit: Fit, covariance: Array, inertia: float, scales: Scales, noise: Array, window: float = 0.0
    ) -> "Knowledge":
        """Take it from the fit of a model.

        Args:
            fit: to the trials that there are.
            covariance: (unknowns, unknowns) of its values.
            inertia: A22 [kg m^2], as good as it is known where no trial shows it.
            scales: of the rig.
            noise: (2,) standard deviation of the noise of theta1 and theta2 [rad].
            window: length of all windows [s]; 0 for as long as the motion can be followed.
        """
        ends: dict[int, float] = {}
        for each in fit.windows:
            ends[each.trial] = max(ends.get(each.trial, 0.0), each.begin + each.duration)
        sampling = Sampling(
            duration=float(np.median(list(ends.values()))),
            interval=float(np.median(np.concatenate([np.diff(each.time) for each in fit.windows]))),
            window=window,
            shortest_window=scales.shortest_piece,
            half_width=scales.half_width,
            step=scales.step,
            noise=noise,
        )
        of_one = float(np.sqrt(fit.variance * fit.autocorrelation.integrated_time))
        mechanism = replace(fit.model.mechanism, inertia=inertia)
        model, remain = replace(fit.model, mechanism=mechanism, zeros=()), ~fit.model.of_zeros
        values, known = fit.values[remain], covariance[np.ix_(remain, remain)]
        found = cls(model, values, known, of_one, sampling)
        return found.with_weights(()).with_zeros_of_its_own(bool(fit.model.zeros))

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
        own = np.insert(np.ones(len(self.values), dtype=bool), places, False)
        spread = np.diag(
            np.insert(np.zeros(len(self.values)), places, [*(np.inf for _ in inverse), *(1.0 for _ in more)])
        )
        spread[np.ix_(own, own)] = self.covariance
        model = replace(model, inertia_free=True, weight_errors=(*known, *more), penalty_of_errors=self.noise**2)
        return replace(self, model=model, values=values, covariance=spread)

    def with_zeros_of_its_own(self, has: bool) -> "Knowledge":
        """Return it with zeros of the next trial's encoders among the unknowns, if it has such."""
        if not has:
            return self
        model, values = self.model.with_zeros(self.values, [NEW])
        spread = np.diag(np.full(len(values), np.inf))
        spread[np.ix_(~model.of_zeros, ~model.of_zeros)] = self.covariance
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

    def places(self, names: Sequence[str]) -> npt.NDArray[np.int64]:
        """Return where unknowns are, by their names."""
        return np.array([self.model.names.index(name) for name in names], dtype=np.int64)

    @property
    def information(self) -> Array:
        """(unknowns, unknowns) inverse of the covariance; 0 for what nothing is known of."""
        seen = np.isfinite(np.diag(self.covariance)) & (np.diag(self.covariance) > 0.0)
        result = np.zeros_like(self.covariance)
        result[np.ix_(seen, seen)] = scaled_inverse(self.covariance[np.ix_(seen, seen)], _UNOBSERVABLE)[0]
        return result
