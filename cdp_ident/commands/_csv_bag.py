"""From a CSV file to a bag, for `import_csv`."""

import argparse
import hashlib
import shlex
from datetime import datetime, timezone

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.csv_file import Table, read_table
from cdp_ident.bag.joint_state import MESSAGE_TYPE, NANOSECONDS, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.commands._csv_arguments import AS_TYPED
from cdp_ident.commands._csv_physics import check_film, what_the_motion_says
from cdp_ident.commands._csv_recording import Recording, recording_of
from cdp_ident.errors import BagError, OptionError, OtherMotionError, TrialError
from cdp_ident.outside_text import utf_8
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import model_angles
from cdp_ident.trial.order import elapsed

Array = npt.NDArray[np.float64]

_ABSOLUTE = 1e9
"""Times [s] from here on, which is 2001, are taken as seconds since 1970."""
_DEFAULT_START = datetime(2000, 1, 1, tzinfo=timezone.utc)
_TAKEN_FOR_GRANTED = {"zero": "upright", "outer_angle": "relative", "inner_sign": 1, "outer_sign": 1}


def make_bag(options: argparse.Namespace, arguments: list[str]) -> None:
    """Make a bag of a CSV file, and print what was taken for what. Raises CdpIdentError where that is not possible."""
    if options.out.exists():
        raise BagError(f"{options.out} exists already and is not overwritten: give another folder")
    table = read_table(options.csv, options.delimiter, options.decimal)
    recording = recording_of(table, options)
    stamps = _stamps(recording.time, options)
    print(f"{options.csv}: {table.format}", *recording.columns, sep="\n  ")
    granted = [
        AS_TYPED.setting(name, value) for name, value in _TAKEN_FOR_GRANTED.items() if getattr(options, name) is None
    ]
    if granted and not recording.on_film:
        print(f"assumed: {', '.join(granted)}")
    print(*recording.notes, sep="\n", end="\n" if recording.notes else "")
    said = _checked(table, recording, options)
    _write(recording, stamps, options, arguments)
    duration = elapsed(np.array(stamps))[-1]
    print(f"{options.out}: {len(stamps)} samples over {duration:.3f} s on /{options.topic.lstrip('/')}")
    print(*said, sep="\n")


def _checked(table: Table, recording: Recording, options: argparse.Namespace) -> list[str]:
    """Check the columns as recorded under the meaning given, and return what there is to say.

    Raises TrialError where identify would refuse the bag, unless the user insists.
    """
    samples = recording.samples()
    try:
        if recording.on_film:
            check_film(samples, recording.meaning)
        found = find_trial(samples, recording.meaning, AS_TYPED)
    except TrialError as error:
        if not options.anyway:
            there = f"; columns: {table.columns}" if isinstance(error, OtherMotionError) else ""
            raise TrialError(f"{options.csv}: identify would refuse it: {error}{there}") from error
        return [f"warning: identify will refuse it: {error}"]
    lines = [f"zero-input motion: {found.trial.duration:.3f} s from {found.trial.start:.3f} s on"]
    lines += [f"  {note}" for note in found.trial.notes if note not in found.warnings]
    lines += [f"warning: {warning}" for warning in found.warnings]
    return lines + what_the_motion_says(found, recording, options.rate)


def _stamps(time: Array, options: argparse.Namespace) -> list[int]:
    """Return the stamp [ns since the epoch] of each of the file's times [s]."""
    if options.start_stamp is not None:
        origin, base = time[0], options.start_stamp
    else:
        origin, base = 0.0, 0 if time[0] >= _ABSOLUTE else round(_DEFAULT_START.timestamp()) * NANOSECONDS
    if not np.abs(time - origin).max() < 2**62 / NANOSECONDS:
        raise BagError(f"{options.csv}: its times reach {np.abs(time).max():.3g} s: check --time and --time-unit")
    stamps = [base + round(seconds * NANOSECONDS) for seconds in (time - origin).tolist()]
    first, last = min(stamps), max(stamps)
    if first <= 0 or last >= 2**31 * NANOSECONDS:
        raise OptionError(
            f"samples would be stamped {first} to {last} ns since 1970: ROS's stamps reach from then to 2038; give "
            "another --start-stamp"
        )
    return stamps


def _write(recording: Recording, stamps: list[int], options: argparse.Namespace, arguments: list[str]) -> None:
    """Write the bag, in the project's conventions."""
    theta = model_angles(recording.samples().angles, recording.meaning)
    names, positions = ["inner_joint", "outer_joint"], [theta[:, 0], theta[:, 1] - theta[:, 0]]
    if recording.cart is not None:
        names.append("cart_joint")
        positions.append(recording.meaning.cart_sign * recording.cart)
    topic = f"/{options.topic.lstrip('/')}"
    efforts = np.full((len(stamps), len(names) if recording.torques is not None else 0), np.nan)
    if recording.torques is not None:
        efforts[:, :2] = recording.torques
    with BagWriter(options.out) as writer:
        for stamp, position, effort in zip(stamps, np.column_stack(positions), efforts.tolist(), strict=True):
            writer.write(topic, MESSAGE_TYPE, stamp, serialize_joint_state(names, position, stamp, efforts=effort))
        source = {
            "source": utf_8(options.csv.name),
            "source_sha256": hashlib.sha256(options.csv.read_bytes()).hexdigest(),
            "made_by": utf_8(f"import_csv {shlex.join(arguments)}"),
        }
        writer.close(source)
