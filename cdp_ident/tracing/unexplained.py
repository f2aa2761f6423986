"""The error that remains when the selection ends: how large, in which joint, and where."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.outlier_windows import outlier_windows
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.effects.effect import JOINTS, Joint
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.noise_memory import forgets_soon, is_structured
from cdp_ident.tracing.torque_residual import TorqueResidual, corrected, torque_residual

Array = npt.NDArray[np.float64]

_SURELY = 2.0
"""Values may be off by so many standard deviations. They explain no more of the held-out error than the noise does."""
_BINS, _FEWEST_IN_BIN = 16, 20


@dataclass(frozen=True)
class Unexplained:
    """What the model with its effects does not explain."""

    significant: bool
    """Whether more than noise remains."""
    joint: Joint
    """In which joint most of it is."""
    times_noise: float
    """The error over what was held out, over the encoders' noise."""
    description: str
    """Where it is and how large, in words."""

    @classmethod
    def not_examined(cls, final: FinalModel, noise: Array) -> "Unexplained":
        """Return what is known where it cannot be examined: its size; arguments are those of `unexplained`."""
        ratios = _errors((final.fit, final.holdout)) / noise
        times = final.holdout.rmse() / float(np.sqrt(np.mean(noise**2)))
        is_large = bool(np.any(ratios >= thresholds.ABOVE_NOISE))
        return cls(is_large, JOINTS[int(np.argmax(ratios))], times, "what remains could not be examined")


def unexplained(
    final: FinalModel, noise: Array, trials: Sequence[str], inertia: float, covariance: Array
) -> Unexplained:
    """Describe what remains.

    Args:
        final: the model with the effects that were found.
        noise: (2,) standard deviation of the noise of theta1 and theta2 [rad].
        trials: names of the trials.
        inertia: A22 [kg m^2], to give torques in N m.
        covariance: (unknowns, unknowns) of the model's values.
    """
    fits = (final.fit, final.holdout)
    errors = _errors(fits)
    ratios = errors / noise
    worst = int(np.argmax(ratios))
    overall = final.holdout.rmse() / float(np.sqrt(np.mean(noise**2)))
    window = _outlier_window(final, noise, trials)
    only = None if window else _only_noise(final, noise, covariance)
    if only:
        return Unexplained(False, JOINTS[worst], overall, only)
    residual = torque_residual(corrected(final.fit))
    dependence = max(_dependences(residual), key=lambda found: found.share)
    remains = f"{1e3 * errors[worst]:.3g} mrad remain in theta{worst + 1}, {ratios[worst]:.1f} times its noise"
    correlated = final.fit.autocorrelation.integrated_time
    slow = f"; it changes slowly, over {correlated:.0f} samples" if is_structured(final.fit) else ""
    description = "; ".join(filter(None, (remains, dependence.words(inertia) + slow, window)))
    return Unexplained(True, JOINTS[dependence.joint], overall, description)


def _only_noise(final: FinalModel, noise: Array, covariance: Array) -> str | None:
    """Return in words what little remains, or None where it is more; arguments are those of `unexplained`."""
    fits = (final.fit, final.holdout)
    if leaves_only_noise(fits, noise):
        is_small = np.all(_errors(fits) < thresholds.ABOVE_NOISE * noise)
        memory = "" if is_small else f", correlated over {final.fit.autocorrelation.integrated_time:.0f} samples"
        return f"nothing but the encoders' noise{memory}"
    if leaves_only_noise([final.fit], noise):
        level = np.maximum(_errors([final.fit]), noise)
        by_values = np.minimum(_SURELY * final.moved_by(covariance), level)
        if np.all(np.hypot(thresholds.ABOVE_NOISE * level, by_values) > _errors([final.holdout])):
            return "nothing but the encoders' noise, and what the values' uncertainty moves the held-out motion by"
    return None


def leaves_only_noise(fits: Sequence[Fit], noise: Array) -> bool:
    """Return whether errors are of the noise's size, or forgotten as soon as noise with a memory is.

    Args:
        fits: a model over some windows each.
        noise: (2,) standard deviation of the noise of theta1 and theta2 [rad].
    """
    return bool(np.all(_errors(fits) < thresholds.ABOVE_NOISE * noise)) or all(map(forgets_soon, fits))


def _errors(fits: Sequence[Fit]) -> Array:
    """Return the largest error of theta1 and of theta2 (2,) [rad]."""
    return np.array([max(fit.rmse(angle) for fit in fits) for angle in range(2)])


@dataclass(frozen=True)
class _Dependence:
    """How the missing torque in a joint varies with an angle or a speed."""

    joint: int
    regressor: str
    unit: str
    share: float
    """Share of the missing torque's mean square that its mean in bins explains."""
    low: float
    high: float
    torque: float
    """Mean missing torque in the bin where it is largest, over A22 [rad/s^2]."""

    def words(self, inertia: float) -> str:
        return (
            f"most of it goes with the {self.regressor}: a torque of {1e3 * inertia * self.torque:.2g} mN m is missing "
            f"in the {JOINTS[self.joint]} joint at {self.low:.2g} to {self.high:.2g} {self.unit}"
        )


def _dependences(residual: TorqueResidual) -> Iterator[_Dependence]:
    for torque_joint in range(2):
        torque = residual.torque[:, torque_joint]
        for joint in range(2):
            wrapped = (residual.angle[:, joint] + np.pi) % (2 * np.pi) - np.pi
            yield _dependence(torque_joint, f"{JOINTS[joint]} joint's angle", "rad", wrapped, torque)
            yield _dependence(torque_joint, f"{JOINTS[joint]} joint's speed", "rad/s", residual.speed[:, joint], torque)


def _dependence(joint: int, regressor: str, unit: str, values: Array, torque: Array) -> _Dependence:
    bins = int(np.clip(len(values) // _FEWEST_IN_BIN, 2, _BINS))
    edges = np.unique(np.quantile(values, np.linspace(0, 1, bins + 1)))
    places = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    counts = np.bincount(places, minlength=len(edges) - 1)
    means = np.bincount(places, weights=torque, minlength=len(edges) - 1) / np.maximum(counts, 1)
    power = float(np.sum(torque**2))
    share = float(np.sum(counts * means**2)) / power if power > 0 else 0.0
    largest = int(np.argmax(np.abs(means)))
    return _Dependence(
        joint, regressor, unit, share, float(edges[largest]), float(edges[largest + 1]), float(means[largest])
    )


def _outlier_window(final: FinalModel, noise: Array, trials: Sequence[str]) -> str | None:
    """Return in words the window that fits far worse than the others, if one does and is above the noise."""
    outliers = outlier_windows((final.fit, final.holdout), thresholds.WINDOW_ABOVE_OTHERS, noise)
    if not outliers:
        return None
    window, times = outliers[0].window, outliers[0].ratio
    end = window.begin + window.duration
    motion = "held-out motion" if any(window is other for other in final.holdout.windows) else "motion"
    return (
        f"the {motion} of trial {trials[window.trial]} from {window.begin:.1f} to {end:.1f} s fits {times:.1f} times "
        "worse than the other windows: something may have happened there"
    )
