# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What remains when the search ends: torques that no law gives, and readings that scatter more than their noise."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.identification import GUESSED, Inertia
from cdp_ident.likelihood.whole_swing import LARGER, WholeSwings
from cdp_ident.model.effects.effect import JOINTS, Joint
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.missing_torque import MissingTorque

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
    torque: Array
    """(2,) root mean square of the missing torque in each joint [N m]; zero where none is missing."""
    description: str
    """What it is and how large, in words."""


def unexplained(final: FinalModel, whole: WholeSwings | None, noise: Array, inertia: Inertia) -> Unexplained:
    """Describe what remains.

    Args:
        final: the model with the effects that were found, as it was judged.
        whole: the same with its final values; None where these were not found.
        noise: (2,) standard deviation of the noise of theta1 and theta2 [rad].
        inertia: A22; where it is but guessed, words give torques over it.
    """
    errors = np.array([max(fit.rmse(angle) for fit in (final.fit, final.holdout)) for angle in range(2)])
    times = final.holdout.rmse() / (whole.noise_level(noise) if whole else float(np.sqrt(np.mean(noise**2))))
    if whole is None:
        worst = int(np.argmax(errors / noise))
        more = bool(np.any(errors > LARGER * noise))
        return Unexplained(more, JOINTS[worst], times, np.zeros(2), "what remains could not be examined")
    over_noise = errors / whole.noise_of_angles(noise)
    worst = int(np.argmax(over_noise))
    missing = MissingTorque.of(whole)
    over_inertia = np.sqrt(np.mean(missing.torque**2 + missing.std**2, axis=0))
    torque = inertia.value * over_inertia
    joints = np.flatnonzero(whole.joints_missing)
    said = " and ".join(f"{_size(over_inertia[k], inertia)} in the {JOINTS[k]} joint" for k in joints)
    moved = f", as if the base moved, with accelerations of {_of_base(whole):.2g} m/s²" if whole.base_moves else ""
    if not np.any(over_noise > LARGER):
        memory = whole.noise.memory
        words = ["nothing but the encoders' noise"]
        if whole.noise.absolute:
            words.append("that of one absolute angle apart from the other's")
        if memory.max() > 0.0:
            words.append(f"of which {100 * memory.max():.0f} % is in the next reading still")
        if late := errors_of_time(whole.noise.time):
            words.append(f"and {late}")
        if said:
            words.append(f"and torques that matter less than that, {said} (root mean square){moved}")
        return Unexplained(False, JOINTS[worst], times, torque, ", ".join(words))
    fitted = np.array([final.fit.rmse(angle) for angle in range(2)]) / whole.noise_of_angles(noise)
    if any(active.is_difference for active in whole.model.effects) and not np.any(fitted > LARGER):
        words = [f"held-out motion is {times:.2g} times its noise off, as trials differ from one another"]
    elif not said:
        words = [f"theta{worst + 1} is {over_noise[worst]:.1f} times its noise off, by what no torque would explain"]
    else:
        dependence = max(_dependences(missing, joints), key=lambda found: found.share)
        worst = dependence.joint
        words = [f"torques of {said} are missing (root mean square){moved}", dependence.words(inertia)]
    return Unexplained(True, JOINTS[worst], times, torque, "; ".join(words))


def errors_of_time(std: float) -> str:
    """Say by how much the times of readings are off [s]; nothing where they are not."""
    return f"errors of {1e3 * std:.2g} ms in the times of both encoders" if std > 0.0 else ""


def _of_base(whole: WholeSwings) -> float:
    """Return the root mean square of the accelerations of a base that moves [m/s^2]."""
    length = whole.model.coefficients(whole.values)[5]
    swings = zip(whole.recorded.swings, whole.impulses, strict=True)
    squares = np.concatenate([np.sum(of[:-1, :, 0] ** 2, axis=1) / swing.spacing**2 for swing, of in swings])
    return float(np.sqrt(np.mean(squares))) * length


def _size(torque: float, inertia: Inertia) -> str:
    """Return a torque over A22 in words."""
    if inertia.relative_std > GUESSED:
        return f"{torque:.2g} 1/s² over A22"
    return f"{1e3 * inertia.value * torque:.2g} mN m"


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

    def words(self, inertia: Inertia) -> str:
        return (
            f"{100 * self.share:.0f} % of that in the {JOINTS[self.joint]} joint goes with the {self.regressor}, which "
            f"is {_size(self.torque, inertia)} at {self.low:.2g} to {self.high:.2g} {self.unit}"
        )


def _dependences(missing: MissingTorque, joints: Iterable[int]) -> Iterator[_Dependence]:
    for torque_joint in joints:
        torque = missing.torque[:, torque_joint]
        for (joint, name), (of, unit) in product(enumerate(JOINTS), (("angle", "rad"), ("speed", "rad/s"))):
            yield _dependence(torque_joint, f"{name} joint's {of}", unit, missing.over(of, joint), torque)


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
