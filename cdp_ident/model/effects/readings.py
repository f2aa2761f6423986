"""From the motion of the rods to the angles that the encoders show."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled
from cdp_ident.model.effects.bending import Load, Motion, bent
from cdp_ident.model.effects.catalogue import kind_of, sensor_law
from cdp_ident.model.effects.effect import JOINTS, SensorEffect
from cdp_ident.model.effects.play import Turned

Array = npt.NDArray[np.float64]
Sensors = Sequence[tuple[SensorEffect, Sequence[float] | Array, slice]]
"""The encoders' effects, with the values of all their parameters and the place of these among the unknowns."""


def encoder_readings(
    motion: Motion,
    sensors: Sensors,
    time: Array,
    first: int,
    load: Load,
    shown: Array | None = None,
    turned: Turned | None = None,
) -> tuple[Array, Array]:
    """Return the angles theta1, theta2 (n, 2) as the encoders show them, and their derivatives (n, 2, d).

    Where the motion comes without derivatives, there are none of the angles either.

    Args:
        motion: the rods' motion.
        sensors: what the encoders do to it.
        time: (n,) time of each sample in the trial [s], ascending.
        first: direction of the first unknown among the d.
        load: of the inner rod, which may bend.
        shown: (2,) theta1, theta2 as the encoders showed them at the first sample [rad], where that is known: it says
            where in its gap one with play is.
        turned: by what encoders with play were turned before, where these samples go on from others.
    """
    for effect, values, place in sensors:
        if effect.bends:
            motion = bent(motion, load, values, first + place.start)
    states, derivatives = motion(0.0)
    if not sensors:
        return states[:, :2], derivatives[:, :2]
    readings, by_directions = states[:, :2].copy(), derivatives[:, :2].copy()
    if any(effect.delays or effect.has_play for effect, _, _ in sensors):
        angles, slopes = _turned_angles(motion, states, derivatives, sensors, time, first, shown, turned or Turned())
        readings[:, 0], readings[:, 1] = angles[0], angles[0] + angles[1]
        by_directions[:, 0], by_directions[:, 1] = slopes[0], slopes[0] + slopes[1]
    _add(sensors, time, first, readings, by_directions)
    return readings, by_directions


def added_by(effect: SensorEffect, values: Sequence[float] | Array, angle: Array, time: Array) -> Array:
    """Return what an encoder adds (n,) to the angle (n,) that it is turned by [rad]."""
    joint = JOINTS.index(effect.joint)
    theta = np.zeros((len(angle), 2))
    theta[:, joint:] = angle[:, None]
    _add([(effect, values, slice(0, 0))], time, 0, theta, np.empty((len(angle), 2, 0)))
    return np.asarray(theta[:, joint] - angle)


def _turned_angles(
    motion: Motion,
    states: Array,
    derivatives: Array,
    sensors: Sensors,
    time: Array,
    first: int,
    shown: Array | None,
    turned: Turned,
) -> tuple[list[Array], list[Array]]:
    """Return the angles by which encoders are turned that are late or have play, and their derivatives.

    The motion comes with its states and derivatives without a delay; the other arguments are those of
    `encoder_readings`.
    """
    angles, slopes = [of_joint(states, k) for k in range(2)], [of_joint(derivatives, k) for k in range(2)]
    for effect, values, place in sensors:
        if effect.delays:
            k = JOINTS.index(effect.joint)
            late_states, late = motion(values[0]) if values[0] else (states, derivatives)
            angles[k], slopes[k] = of_joint(late_states, k), of_joint(late, k).copy()
            if late.shape[2]:
                slopes[k][:, first + place.start] = -of_joint(late_states[:, 2:], k)
    for effect, values, place in sensors:
        if effect.has_play:
            k = JOINTS.index(effect.joint)
            before = (
                None if shown is None else _turned_by(of_joint(shown[None], k), k, sensors, angles[k][:1], time[:1])
            )
            followed = turned.follow(k, time, angles[k], values[0], before)
            angles[k], slopes[k] = followed.angle, followed.slopes(slopes[k])
            if derivatives.shape[2]:
                slopes[k][:, first + place.start] += followed.by_gap
    return angles, slopes


def _turned_by(shown: Array, joint: int, sensors: Sensors, angle: Array, time: Array) -> float:
    """Return what an encoder is turned by that shows an angle (1,), without what its other effects add to it [rad]."""
    others = (added_by(effect, v, angle, time) for effect, v, _ in sensors if effect.joint == JOINTS[joint])
    return float((shown - sum(others, np.zeros(1)))[0])


def _add(sensors: Sensors, time: Array, first: int, readings: Array, derivatives: Array) -> None:
    """Add to angles (n, 2) that encoders are turned by, and their derivatives (n, 2, d), what they add to each."""
    adding = [sensor for sensor in sensors if sensor[0].law is not None]
    width = max((len(values) for _, values, _ in adding), default=0)
    table, of_all = np.empty((len(adding), 3), dtype=np.int64), np.zeros((len(adding), width))
    for row, parameters, (effect, values, place) in zip(table, of_all, adding, strict=True):
        row[:] = kind_of(effect), JOINTS.index(effect.joint), first + place.start
        parameters[: len(values)] = values
    _add_each(time, table, of_all, readings, derivatives)


@compiled
def _add_each(time, table, values, readings, derivatives):
    # In the table: the number of an effect's law, its joint, and the direction of its first parameter.
    directions, width = np.uint64(derivatives.shape[2]), values.shape[1]
    slopes = np.zeros((len(table), 1 + width))
    for j in range(len(readings)):
        inner, outer = readings[j, 0], readings[j, 1] - readings[j, 0]
        by_inner, by_outer = 0.0, 0.0
        for e in range(len(table)):
            if table[e, 1] == 0:
                added = sensor_law(table[e, 0], inner, time[j], values, e, slopes)
                readings[j, 0] += added
                by_inner += slopes[e, 0]
            else:
                added = sensor_law(table[e, 0], outer, time[j], values, e, slopes)
                by_outer += slopes[e, 0]
            # Both absolute angles contain the inner encoder's.
            readings[j, 1] += added
        if directions == 0:
            continue
        for i in range(directions):
            one, two = derivatives[j, 0, i], derivatives[j, 1, i]
            derivatives[j, 0, i] = one + by_inner * one
            derivatives[j, 1, i] = two + by_inner * one + by_outer * (two - one)
        for e in range(len(table)):
            for p in range(width):  # of parameters that an effect lacks the slopes stay zero
                direction = table[e, 2] + p
                if direction < derivatives.shape[2]:
                    derivatives[j, 1, direction] += slopes[e, 1 + p]
                    if table[e, 1] == 0:
                        derivatives[j, 0, direction] += slopes[e, 1 + p]


def of_joint(values: Array, joint: int) -> Array:
    """Return what a joint has, which turns by theta1 or theta2 - theta1, of values (n, 2 or more, …) of both rods."""
    return values[:, 0] if joint == 0 else values[:, 1] - values[:, 0]
