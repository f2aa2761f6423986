"""From a bag's joints to the model's: which column is which, and the conventions of the numbers."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.errors import TrialError
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.outliers import outlier_words, outliers

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

_BELIEVED = 1e6
"""Largest position [rad or m] that is accepted as a measurement."""


@dataclass(frozen=True)
class Samples:
    """The samples of the joints that matter, as recorded."""

    stamps: Indices
    """(n,) time of each sample [ns since the epoch]."""
    angles: Array
    """(n, 2) positions of the inner and outer joint [rad]."""
    cart: Array | None
    """(n,) position of the cart [m]."""
    torques: Array | None = None
    """(n, 2) torque of a motor in each joint, as measured or commanded; None where none is known."""

    def __getitem__(self, chosen: Mask | Indices) -> "Samples":
        """Return some of the samples."""
        cart, torques = (None if values is None else values[chosen] for values in (self.cart, self.torques))
        return Samples(self.stamps[chosen], self.angles[chosen], cart, torques)


def select_joints(recording: JointRecording, options: TrialOptions) -> tuple[Samples, list[str]]:
    """Pick the joints that the options name; samples without a usable number are dropped.

    Returns the samples and what there is to say about them. Raises TrialError where a joint is missing.
    """
    notes = []
    wanted = [options.inner_joint, options.outer_joint]
    if missing := [joint for joint in wanted if joint not in recording.joints]:
        there = ", ".join(recording.joints) or "no joint at all"
        raise TrialError(
            f"{recording.name}: topic {recording.topic} has no joint {' and no joint '.join(missing)}; it has {there}: "
            "name the joints by inner_joint and outer_joint"
        )
    angles = recording.positions[:, [recording.joints.index(joint) for joint in wanted]]
    usable = np.all(_usable(angles), axis=1)
    if dropped := int(np.count_nonzero(~usable)):
        notes.append(f"{dropped} of {len(usable)} samples have no usable number for both rods and are dropped")
    if not np.any(usable):
        raise TrialError(
            f"{recording.name}: no message on {recording.topic} has a usable number for both {' and '.join(wanted)}"
        )
    cart = None
    if options.cart_joint in recording.joints:
        position = recording.positions[:, recording.joints.index(options.cart_joint)]
        known = _usable(position)
        if np.any(known):
            # A cart published in messages of its own is taken at the times of the rods' samples.
            stamps, first = np.unique(recording.stamps[known], return_index=True)
            times = (stamps - recording.stamps[usable][0]) * 1e-9
            position = position[known][first]
            outlying = outliers(times, position)
            if np.any(outlying):
                notes.append(f"of the cart's position {outlier_words(times[outlying], np.count_nonzero(~outlying))}")
            cart = np.interp(
                (recording.stamps[usable] - recording.stamps[usable][0]) * 1e-9, times[~outlying], position[~outlying]
            )
    elif options.cart_joint:
        notes.append(f"there is no joint {options.cart_joint}: the cart is taken to be at rest")
    return Samples(recording.stamps[usable], angles[usable], cart, _torques(recording, wanted, usable)), notes


def _torques(recording: JointRecording, joints: list[str], usable: Mask) -> Array | None:
    """Return the efforts of two joints where any is known and not zero."""
    if recording.efforts is None:
        return None
    efforts = recording.efforts[:, [recording.joints.index(joint) for joint in joints]][usable]
    efforts = np.where(_usable(efforts), efforts, 0.0)
    return efforts if np.any(efforts) else None


def model_angles(angles: Array, options: TrialOptions) -> Array:
    """Return theta1, theta2 (n, 2) [rad] of the continuous angles of the inner and outer joint (n, 2) [rad]."""
    offset = np.pi if options.zero == "hanging" else 0.0

    def absolute(joint: Array, sign: int, scale: float) -> Array:
        # Where the rods hang, encoders are right whatever their scale is.
        reading = sign * joint + offset
        return np.asarray(reading + (1.0 / scale - 1.0) * (reading - np.pi))

    theta1 = absolute(angles[:, 0], options.inner_sign, options.inner_scale)
    if options.outer_angle == "absolute":
        return np.column_stack([theta1, absolute(angles[:, 1], options.outer_sign, options.outer_scale)])
    return np.column_stack([theta1, theta1 + options.outer_sign * angles[:, 1] / options.outer_scale])


def _usable(values: Array) -> Mask:
    with np.errstate(invalid="ignore"):
        return np.abs(values) <= _BELIEVED
