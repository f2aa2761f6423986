"""From a CSV file to a bag, for `import_csv`."""

import argparse
import hashlib
import shlex

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.bag.csv_file import Table, read_table
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.commands._csv_arguments import AS_TYPED
from cdp_ident.commands._csv_physics import check_film, what_the_motion_says
from cdp_ident.commands._csv_recording import Recording, recording_of
from cdp_ident.errors import BagError, OtherMotionError, TrialError
from cdp_ident.outside_text import shown, utf_8
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import model_angles
from cdp_ident.trial.order import elapsed

_TAKEN_FOR_GRANTED = {"zero": "upright", "outer_angle": "relative", "inner_sign": 1, "outer_sign": 1}


def make_bag(options: argparse.Namespace, arguments: list[str]) -> None:
    """Make a bag of a CSV file, and print what was taken for what. Raises CdpIdentError where that is not possible."""
    if options.out.exists():
        raise BagError(f"{options.out} exists already and is not overwritten: give another folder")
    table = read_table(options.csv, options.delimiter, options.decimal)
    recording = recording_of(table, options)
    print(f"{shown(options.csv)}: {table.format}", *recording.columns, sep="\n  ")
    granted = [
        AS_TYPED.setting(name, value) for name, value in _TAKEN_FOR_GRANTED.items() if getattr(options, name) is None
    ]
    if granted and not recording.on_film:
        print(f"assumed: {', '.join(granted)}")
    print(*recording.notes, sep="\n", end="\n" if recording.notes else "")
    said = _checked(table, recording, options)
    _write(recording, options, arguments)
    stamps = recording.samples.stamps
    duration = elapsed(stamps)[-1]
    print(f"{options.out}: {len(stamps)} samples over {duration:.3f} s on /{options.topic.lstrip('/')}")
    print(*said, sep="\n")


def _checked(table: Table, recording: Recording, options: argparse.Namespace) -> list[str]:
    """Check the columns as recorded under the meaning given, and return what there is to say.

    Raises TrialError where identify would refuse the bag, unless the user insists.
    """
    samples = recording.samples
    try:
        if recording.on_film:
            check_film(samples, recording.meaning)
        found = find_trial(samples, recording.meaning, AS_TYPED)
    except TrialError as error:
        if not options.anyway:
            there = f"; columns: {table.columns}" if isinstance(error, OtherMotionError) else ""
            raise TrialError(f"{options.csv}: identify would refuse it: {error}{there}") from error
        return [f"warning: identify will refuse it: {error}"]
    kind = "zero-input motion" if found.trial.torques is None else "motion driven by motors"
    lines = [f"{kind}: {found.trial.duration:.3f} s from {found.trial.start:.3f} s on"]
    lines += [f"  {note}" for note in found.trial.notes if note not in found.warnings]
    lines += [f"warning: {warning}" for warning in found.warnings]
    return lines + what_the_motion_says(found, recording, options.rate)


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
