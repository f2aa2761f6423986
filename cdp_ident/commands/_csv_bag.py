# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a CSV file to a bag, for `import_csv`: length, rate and gravity's direction are compared with the motion."""

import argparse
import hashlib
import shlex

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.bag.csv_file import Table, read_table
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.commands._csv_recording import Recording, recording_of
from cdp_ident.errors import BagError, OtherMotionError, TrialError
from cdp_ident.model.parameters import CONSTANTS, NOMINAL
from cdp_ident.outside_text import shown, utf_8
from cdp_ident.trial.conventions import gravity_of
from cdp_ident.trial.find import Found, find_trial
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.order import elapsed

_TAKEN_FOR_GRANTED = {"zero": "upright", "outer_angle": "relative", "inner_sign": 1, "outer_sign": 1}
_LARGEST_LEAN = 0.3
"""Largest lean of a camera [rad]; beyond it, columns are likely exchanged."""
_LENGTH_OFF = 0.05
"""Share by which the length that the motion shows may differ from the one given, besides four standard deviations."""
_WELL_KNOWN = 0.2
"""Standard deviation, as a share, up to which a length is worth saying."""


def make_bag(options: argparse.Namespace, arguments: list[str]) -> None:
    """Make a bag of a CSV file, and print what was taken for what. Raises CdpIdentError where that is not possible."""
    if options.out.exists():
        raise BagError(f"{options.out} exists already and is not overwritten: give another folder")
    table = read_table(options.csv, options.delimiter, options.decimal)
    recording = recording_of(table, options)
    print(f"{shown(options.csv)}: {table.format}", *recording.columns, sep="\n  ")
    granted = [
        recording.meaning.setting(name, value)
        for name, value in _TAKEN_FOR_GRANTED.items()
        if getattr(options, name) is None
    ]
    if granted and not recording.on_film:
        print(f"assumed: {', '.join(granted)}")
    print(*recording.notes, sep="\n", end="\n" if recording.notes else "")
    said = _checked(table, recording, options)
    _write(recording, options, arguments)
    stamps = recording.samples.stamps
    duration = elapsed(stamps)[-1]
    print(f"{shown(options.out)}: {len(stamps)} samples over {duration:.3f} s on /{shown(options.topic.lstrip('/'))}")
    print(*said, sep="\n")


def _checked(table: Table, recording: Recording, options: argparse.Namespace) -> list[str]:
    """Check the columns as recorded under the meaning given, and return what there is to say.

    Raises TrialError where identify would refuse the bag, unless the user insists.
    """
    samples = recording.samples
    try:
        if recording.on_film:
            _check_film(samples, recording.meaning)
        found = find_trial(samples, recording.meaning)
        said = _what_the_motion_says(found, recording, options.rate)
    except TrialError as error:
        if not options.anyway:
            there = f"; columns: {table.columns}" if isinstance(error, OtherMotionError) else ""
            raise TrialError(f"{options.csv}: identify would refuse it: {error}{there}") from error
        return [f"warning: identify will refuse it: {error}"]
    kind = "zero-input motion" if found.trial.torques is None else "motion driven by motors"
    lines = [f"{kind}: {found.trial.duration:.3f} s from {found.trial.start:.3f} s on"]
    lines += [f"  {note}" for note in found.trial.notes if note not in found.warnings]
    lines += [f"warning: {warning}" for warning in found.warnings]
    return lines + said


def _write(recording: Recording, options: argparse.Namespace, arguments: list[str]) -> None:
    """Write the bag, in the project's conventions."""
    samples = recording.samples
    theta = model_angles(samples.angles, recording.meaning)
    names, positions = ["inner_joint", "outer_joint"], [theta[:, 0], theta[:, 1] - theta[:, 0]]
    if samples.cart is not None:
        names.append("cart_joint")
        positions.append(recording.meaning.cart_sign * samples.cart)
    topic = f"/{options.topic.lstrip('/')}"
    efforts: Array = np.empty((len(theta), 0))
    if samples.torques is not None:
        efforts = np.pad(samples.torques, ((0, 0), (0, len(names) - 2)))
    with BagWriter(options.out) as writer:
        rows = zip(samples.stamps.tolist(), np.column_stack(positions).tolist(), efforts.tolist(), strict=True)
        for stamp, position, effort in rows:
            writer.write(topic, MESSAGE_TYPE, stamp, serialize_joint_state(names, position, stamp, efforts=effort))
        source = {
            "source": utf_8(options.csv.name),
            "source_sha256": hashlib.sha256(options.csv.read_bytes()).hexdigest(),
            "made_by": utf_8(f"import_csv {shlex.join(arguments)}"),
        }
        writer.close(source)


def _check_film(samples: Samples, meaning: TrialOptions) -> None:
    """Raise TrialError where gravity does not pull down in the picture."""
    directions = gravity_of(samples, meaning)
    lean = 0.0 if directions is None else float(np.angle(np.mean(np.exp(1j * directions))))
    if abs(lean) <= _LARGEST_LEAN:
        return
    degrees = np.degrees(lean)
    if abs(abs(degrees) - 180) < np.degrees(_LARGEST_LEAN):
        raise TrialError("gravity pulls up in the picture: y counts the other way, give the other --y-axis")
    raise TrialError(
        f"gravity's direction is about {degrees:.0f} degrees from the picture's vertical: check which columns are x "
        "and y; if the camera leans so, --lean takes it out"
    )


def _what_the_motion_says(found: Found, recording: Recording, rate: float | None) -> list[str]:
    """Return lines about how well the balance of forces holds, and with which length.

    Raises TrialError where the motion is that of no pendulum that anybody has.
    """
    if found.balance is None or not found.balance.lumped.has_certain_signs:
        return []
    lumped, g = found.balance.lumped, NOMINAL["g"]
    holds = f"balance of forces: {lumped.unexplained:.1%} of the inner rod's acceleration is unexplained"
    length, std = (g * of for of in lumped.length_over_gravity)
    if not (length > 0 and std < _WELL_KNOWN * length):
        return [holds]
    if not CONSTANTS[0].lower_factor < length / CONSTANTS[0].nominal < CONSTANTS[0].upper_factor:
        raise TrialError(f"the motion is that of joints {length:.2g} m apart: check --time-unit, or --rate")
    holds += f"; it holds with L = {length:.3g} +- {max(std, 1e-3 * length):.1g} m at g = {g:g} m/s^2"
    given = recording.length
    if not given or abs(length / given - 1) <= _LENGTH_OFF + 4 * std / given:
        return [holds]
    faster = np.sqrt(given / length)
    remedy = f"--rate {rate / faster:.4g}" if rate else f"times that are {faster:.3g} times as long"
    return [
        holds,
        f"warning: the joints are {given:.3g} m apart, but the motion is that of {length:.3g} m: with {remedy} "
        "they agree; check rate, times and length",
    ]
