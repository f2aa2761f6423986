# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What encoders make of a motion: their errors, noise, and counts."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter, lsim

from reference.plant import Path
from reference.torques import Joint

Array = npt.NDArray[np.float64]

_FINER = 8
"""An elastic coupling is followed so many times between two samples."""


@dataclass(frozen=True)
class Turned:
    """What both encoders are turned by."""

    values: Mapping[str, float]
    """The rig's physical values."""
    path: Path
    """The rods' motion at the samples."""
    joints: Array
    """(n, 2) angles of the inner joint from hanging and of the outer one from straight, when they are read [rad]."""


Reading = Callable[[Turned], Array]
"""From what the encoders are turned by to what is added to their angles (n, 2) [rad]."""


def _on(joint: Joint, added: Callable[[Array, Array], Array]) -> Reading:
    """Return an error of one encoder, given what is added to it from its angle (n,) and the time (n,)."""
    column = 0 if joint == "inner" else 1

    def reading(turned: Turned) -> Array:
        both = np.zeros_like(turned.joints)
        both[:, column] = added(turned.joints[:, column], turned.path.times)
        return both

    return reading


def offset(joint: Joint, size: float) -> Reading:
    """Return an encoder that is off by an angle [rad]."""
    return _on(joint, lambda angle, time: np.full_like(angle, size))


def drifting_offset(joint: Joint, size: float, duration: float) -> Reading:
    """Return an encoder whose zero is off by an angle [rad] after a time [s], and goes on so."""
    return _on(joint, lambda angle, time: size * time / duration)


def scale(joint: Joint, size: float) -> Reading:
    """Return an encoder with other counts a turn than thought, by a share of them."""
    return _on(joint, lambda angle, time: size * angle)


def eccentricity(joint: Joint, size: float, phase: float) -> Reading:
    """Return a disc beside its axle [rad]."""
    return _on(joint, lambda angle, time: size * np.sin(angle + phase))


def harmonic(joint: Joint, size: float, periods: int, phase: float) -> Reading:
    """Return an error that repeats so many times a turn [rad]."""
    return _on(joint, lambda angle, time: size * np.sin(periods * angle + phase))


def oblique_view(size: float, axis: float) -> Reading:
    """Return a camera that looks askew: a circle is an ellipse whose longer axis is at an angle [rad].

    Its axes are as 1 + 2 `size` to 1.
    """

    def reading(turned: Turned) -> Array:
        away = np.cumsum(turned.joints, axis=1) - axis
        seen = np.arctan2(np.sin(away), (1.0 + 2.0 * size) * np.cos(away))
        off = (seen - away + math.pi) % (2.0 * math.pi) - math.pi
        return np.diff(off, axis=1, prepend=0.0)

    return reading


def elastic_coupling(joint: Joint, compliance: float, damping: float) -> Reading:
    """Return an encoder whose own oscillation, of so much damping, the joint's acceleration drives.

    Args:
        joint: of the encoder.
        compliance: one over the square of its natural frequency [s^2].
        damping: relative to the critical one.
    """
    of_joint = ([-compliance], [compliance, 2.0 * damping * math.sqrt(compliance), 1.0])
    return _driven(joint, of_joint, lambda path: path.accelerations)


def low_pass(joint: Joint, time_constant: float) -> Reading:
    """Return a filter of first order behind an encoder, with its time constant [s]."""
    return _driven(joint, ([-time_constant], [time_constant, 1.0]), lambda path: path.states[:, 2:])


def _driven(joint: Joint, system: tuple[list[float], list[float]], by: Callable[[Path], Array]) -> Reading:
    """Return an error that a linear system (numerator and denominator) makes of the joint's speed or acceleration."""
    column = 0 if joint == "inner" else 1

    def reading(turned: Turned) -> Array:
        times = turned.path.times
        fine = np.linspace(times[0], times[-1], _FINER * (len(times) - 1) + 1)
        driven = CubicSpline(times, np.diff(by(turned.path), axis=1, prepend=0.0)[:, column])(fine)
        # It begins where a steady input holds it.
        steady = lsim(system, np.full(2, driven[0]), [0.0, 1e3])[2][-1]
        both = np.zeros_like(turned.joints)
        both[:, column] = lsim(system, driven, fine - fine[0], X0=steady)[1][::_FINER]
        return both

    return reading


def slip(joint: Joint, size: float, at: float) -> Reading:
    """Return an encoder that misses counts [rad] at a time [s]."""
    return _on(joint, lambda angle, time: np.where(time >= at, size, 0.0))


def backlash(joint: Joint, half: float) -> Reading:
    """Return an encoder whose coupling has play, of which half is given [rad]."""

    def play(angle: Array, time: Array) -> Array:
        shown = np.empty_like(angle)
        last = angle[0]
        for k, now in enumerate(angle):
            last = min(max(last, now - half), now + half)
            shown[k] = last
        return shown - angle

    return _on(joint, play)


def rod_flex(compliance: float, end_share: float = 0.5) -> Reading:
    """Return an inner rod that the outer one bends, by its end's deflection over the force there [m/N].

    A cantilever loaded at its end leaves its chord by a slope of F L^2 / (3 E I) at the root and half of that at the
    end (Euler and Bernoulli); the encoders sit at these. A rod that is not the same all along has another share.
    """

    def reading(turned: Turned) -> Array:
        v, (theta1, theta2, omega1, omega2), alpha = turned.values, turned.path.states.T, turned.path.accelerations.T
        s1, k1, s2, k2 = np.sin(theta1), np.cos(theta1), np.sin(theta2), np.cos(theta2)
        along = v["L"] * (k1 * alpha[0] - s1 * omega1**2) + v["l2"] * (k2 * alpha[1] - s2 * omega2**2)
        up = v["g"] - v["L"] * (s1 * alpha[0] + k1 * omega1**2) - v["l2"] * (s2 * alpha[1] + k2 * omega2**2)
        across = -v["m2"] * (k1 * along - s1 * up) - v["m0"] * (v["L"] * alpha[0] - v["g"] * s1)
        bent = compliance / v["L"] * across
        return np.stack([-bent, -end_share * bent], axis=1)

    return reading


def joint_angles(path: Path) -> Array:
    """Return the joints' angles (n, 2) from hanging and from straight [rad]."""
    theta1, theta2 = path.states[:, 0], path.states[:, 1]
    return np.stack([theta1 - math.pi, theta2 - theta1], axis=1)


def theta_of(joints: Array) -> Array:
    """Return theta1, theta2 (n, 2) [rad] from the joints' angles."""
    return np.asarray(np.cumsum(joints, axis=1) + math.pi)


@dataclass(frozen=True)
class Counter:
    """How an encoder's angle becomes a number."""

    counts: int
    """Counts a turn."""
    noise: float
    """Standard deviation of what is added before it is counted [rad]."""
    memory: float = 0.0
    """Correlation of that from one sample to the next."""

    @property
    def error(self) -> float:
        """Standard deviation of the whole error [rad]."""
        return math.hypot(self.noise, self.step / math.sqrt(12.0))

    @property
    def step(self) -> float:
        """Of one count [rad]."""
        return 2.0 * math.pi / self.counts

    def count(self, joints: Array, rng: np.random.Generator) -> Array:
        """Return joints' angles (n, 2) as they are counted [rad]."""
        white = rng.normal(scale=self.noise, size=joints.shape)
        fresh = math.sqrt(1.0 - self.memory**2)
        added = lfilter([fresh], [1.0, -self.memory], white, axis=0, zi=(1.0 - fresh) * white[:1])[0]
        return np.asarray(np.round((joints + added) / self.step) * self.step)
