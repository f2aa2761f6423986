"""What is known of a rig before its next trial."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import scaled_inverse
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.scales import Scales

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


@dataclass(frozen=True)
class Knowledge:
    """A fitted model, how sure its values are, and how a further trial would be measured."""

    model: MotionModel
    """The model; where each trial's encoders have zeros of their own, the next trial's are among its unknowns."""
    values: Array
    """(unknowns,) the fitted values; those of zeros that are not known yet are 0."""
    covariance: Array
    """(unknowns, unknowns) of them; infinite for what nothing is known of."""
    noise: float
    """Standard deviation of a whitened angle, were all angles independent [rad]."""
    whitening: Array
    """(2, 2) what makes the angles' errors independent and alike; see `fit/reweighting.py`."""
    sampling: Sampling

    @classmethod
    def of(cls, fit: Fit, covariance: Array, scales: Scales, window: float = 0.0) -> "Knowledge":
        """Take it from the fit of a model.

        Args:
            fit: to the trials that there are.
            covariance: (unknowns, unknowns) of its values.
            scales: of the rig.
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
        )
        noise = float(np.sqrt(fit.variance * fit.autocorrelation.integrated_time))
        # The next trial has no weight: it says nothing of A22, nor of what other trials' weights are wrong by.
        model, remain = fit.model.with_inertia_known(fit.values)
        model = replace(model, zeros=(), weight_errors=())
        remain &= fit.model.of_rig
        values, known = fit.values[remain], covariance[np.ix_(remain, remain)]
        whitening = fit.windows[0].whitening
        return cls(model, values, known, noise, whitening, sampling).with_zeros_of_its_own(bool(fit.model.zeros))

    def with_zeros_of_its_own(self, has: bool) -> "Knowledge":
        """Return it with zeros of the next trial's encoders among the unknowns, if it has such."""
        if not has:
            return self
        model, values = self.model.with_zeros(self.values, [NEW])
        spread = np.diag(np.full(len(values), np.inf))
        spread[np.ix_(model.of_rig, model.of_rig)] = self.covariance
        return replace(self, model=model, values=values, covariance=spread)

    @property
    def asked(self) -> tuple[str, ...]:
        """Names of the unknowns that a user may ask for: neither zeros of a trial nor coefficients of curves."""
        may = self.model.of_rig & ~self.model.of_curves
        return tuple(name for name, may_be in zip(self.model.names, may, strict=True) if may_be)

    def places(self, names: Sequence[str]) -> npt.NDArray[np.int64]:
        """Return where unknowns are, by their names."""
        return np.array([self.model.names.index(name) for name in names], dtype=np.int64)

    @property
    def noise_of_angles(self) -> Array:
        """(2,) standard deviation of theta1 and theta2, were all angles independent [rad]."""
        back = np.linalg.inv(self.whitening)
        return np.asarray(self.noise * np.sqrt(np.diag(back @ back.T)))

    @property
    def information(self) -> Array:
        """(unknowns, unknowns) inverse of the covariance; 0 for what nothing is known of."""
        seen = np.isfinite(np.diag(self.covariance)) & (np.diag(self.covariance) > 0.0)
        result = np.zeros_like(self.covariance)
        result[np.ix_(seen, seen)] = scaled_inverse(self.covariance[np.ix_(seen, seen)], _UNOBSERVABLE)[0]
        return result
