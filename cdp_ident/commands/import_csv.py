"""Make a bag of a CSV file: `import_csv CSV --out DIR …`."""

import argparse
import hashlib
import shlex
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.csv_file import read_columns
from cdp_ident.bag.joint_state import MESSAGE_TYPE, NANOSECONDS, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.errors import BagError, OptionError, TrialError
from cdp_ident.trial.joints import model_angles
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions

Array = npt.NDArray[np.float64]

_TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_ANGLE_UNITS = {"rad": 1.0, "deg": np.pi / 180, "turns": 2 * np.pi}
_LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_ABSOLUTE = 1e9
"""Times [s] from here on, which is 2001, are taken as seconds since 1970."""
_DEFAULT_START = datetime(2000, 1, 1, tzinfo=timezone.utc)

_EPILOG = """
The bag holds sensor_msgs/JointState in the conventions of cdp_ident: radians and metres, zero upright, positive towards
+x, inner_joint, outer_joint (relative to the inner rod) and cart_joint. What the file means by its numbers is said by
the options; afterwards the physics of the motion is checked against it, and a warning printed if they disagree.

example: a recording at 1 kHz with absolute angles, of which every fifth sample from 10 s on is taken
  import_csv swing.csv.gz --out swing --time time_s --inner theta1_rad --outer theta2_rad --outer-angle absolute \\
      --from 10 --every 5
example: encoder counts in columns 1 and 2, zero where the rods hang, milliseconds in column 0
  import_csv log.txt --out swing --time-unit ms --angle-unit counts --counts-per-turn 8000 --zero hanging
"""


def _parser() -> ArgumentParser:
    parser = ArgumentParser(
        "import_csv", "Make a rosbag2 bag, which identify takes, of a CSV file with measured angles.", _EPILOG
    )
    parser.add_argument("csv", type=Path, metavar="CSV", help="the file, also compressed with gzip")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the new bag; must not exist")
    columns = parser.add_argument_group("columns, by title or by number counted from 0")
    columns.add_argument("--time", default="0", metavar="COLUMN", help="time (default: 0)")
    columns.add_argument("--inner", default="1", metavar="COLUMN", help="angle of the inner rod (default: 1)")
    columns.add_argument("--outer", default="2", metavar="COLUMN", help="angle of the outer rod (default: 2)")
    columns.add_argument("--cart", metavar="COLUMN", help="position of the cart (default: none, it is at rest)")
    columns.add_argument("--delimiter", metavar="SIGN", help="between columns (default: found in the first line)")
    columns.add_argument("--decimal", default=".", choices=(".", ","), help="decimal sign (default: .)")
    units = parser.add_argument_group("units")
    units.add_argument("--time-unit", default="s", choices=_TIME_UNITS, help="(default: s)")
    units.add_argument("--angle-unit", default="rad", choices=(*_ANGLE_UNITS, "counts"), help="(default: rad)")
    units.add_argument(
        "--counts-per-turn", type=float, nargs="+", metavar="N", help="encoder counts, of both joints or of each"
    )
    units.add_argument("--cart-unit", default="m", choices=(*_LENGTH_UNITS, "counts"), help="(default: m)")
    units.add_argument("--counts-per-metre", type=float, metavar="N", help="encoder counts of the cart")
    meaning = parser.add_argument_group("what the angles mean")
    meaning.add_argument("--zero", default="upright", choices=("upright", "hanging"), help="(default: upright)")
    meaning.add_argument(
        "--outer-angle", default="relative", choices=("relative", "absolute"), help="(default: relative)"
    )
    for joint in ("inner", "outer", "cart"):
        meaning.add_argument(f"--{joint}-sign", type=int, default=1, choices=(1, -1), help="(default: 1, towards +x)")
    choice = parser.add_argument_group("what is taken")
    choice.add_argument(
        "--from", dest="start", type=float, default=-np.inf, metavar="S", help="file's time [s] to begin at"
    )
    choice.add_argument("--to", dest="stop", type=float, default=np.inf, metavar="S", help="file's time [s] to end at")
    choice.add_argument("--every", type=int, default=1, metavar="N", help="take every Nth sample (default: 1)")
    stamps = parser.add_argument_group("how it is written")
    stamps.add_argument(
        "--start-stamp",
        type=_stamp,
        metavar="WHEN",
        help="when the first sample was measured, as 2024-05-31T12:00:00Z or seconds since 1970 (default: the file's "
        "own time if it counts from 1970, else its time is counted from the beginning of 2000)",
    )
    stamps.add_argument("--topic", default="joint_states", help="(default: joint_states)")
    return parser


def _stamp(text: str) -> int:
    """Return nanoseconds since 1970 of a date or of seconds."""
    try:
        return round(float(text) * NANOSECONDS)
    except ValueError:
        pass
    try:
        moment = datetime.fromisoformat(text.replace("Z", "+00:00"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f"{text!r} is neither a date such as 2024-05-31T12:00:00Z nor seconds"
        ) from error
    moment = moment if moment.tzinfo else moment.replace(tzinfo=timezone.utc)
    return round(moment.timestamp() * 1e6) * 1000


def _angle_factors(options: argparse.Namespace) -> Array:
    """Return what the two angle columns are multiplied with to give radians."""
    counts = options.counts_per_turn or []
    if options.angle_unit != "counts":
        if counts:
            raise OptionError("--counts-per-turn goes with --angle-unit counts")
        return np.full(2, _ANGLE_UNITS[options.angle_unit])
    if len(counts) not in (1, 2) or not all(np.isfinite(n) and n > 0 for n in counts):
        raise OptionError("--angle-unit counts needs --counts-per-turn with one or two positive numbers")
    return 2 * np.pi / np.array([counts[0], counts[-1]])


def _cart_factor(options: argparse.Namespace) -> float:
    """Return what the cart's column is multiplied with to give metres."""
    if options.cart_unit != "counts":
        return _LENGTH_UNITS[options.cart_unit]
    if not (options.counts_per_metre and options.counts_per_metre > 0):
        raise OptionError("--cart-unit counts needs --counts-per-metre with a positive number")
    return 1.0 / float(options.counts_per_metre)


def _stamps(time: Array, options: argparse.Namespace) -> list[int]:
    """Return the stamp [ns since the epoch] of each of the file's times [s]."""
    if options.start_stamp is not None:
        origin, base = time[0], options.start_stamp
    else:
        origin, base = 0.0, 0 if time[0] >= _ABSOLUTE else round(_DEFAULT_START.timestamp()) * NANOSECONDS
    if not np.abs(time - origin).max() < 2**62 / NANOSECONDS:
        raise BagError(f"{options.csv}: its times reach {np.abs(time).max():.3g} s: check --time and --time-unit")
    stamps = [base + round(seconds * NANOSECONDS) for seconds in (time - origin).tolist()]
    if min(stamps) <= 0:
        raise OptionError(f"the first sample would be stamped {min(stamps)} ns since 1970: give a later --start-stamp")
    return stamps


def _joints(table: Array, options: argparse.Namespace) -> tuple[list[str], Array]:
    """Return the names and positions (n, joints) of the joints in the project's conventions."""
    meaning = TrialOptions(
        zero=options.zero,
        outer_angle=options.outer_angle,
        inner_sign=options.inner_sign,
        outer_sign=options.outer_sign,
    )
    angles = np.asarray(np.unwrap(table[:, 1:3] * _angle_factors(options), axis=0))
    theta = model_angles(angles, meaning)
    names, positions = ["inner_joint", "outer_joint"], [theta[:, 0], theta[:, 1] - theta[:, 0]]
    if options.cart is not None:
        names.append("cart_joint")
        positions.append(options.cart_sign * _cart_factor(options) * table[:, 3])
    return names, np.column_stack(positions)


def _table(options: argparse.Namespace) -> tuple[Array, int]:
    """Return the rows that are taken (n, columns), times in seconds, and how many lack a number."""
    columns = [options.time, options.inner, options.outer, *([] if options.cart is None else [options.cart])]
    table = read_columns(options.csv, columns, options.delimiter, options.decimal)
    table[:, 0] *= _TIME_UNITS[options.time_unit]
    usable = np.all(np.isfinite(table), axis=1)
    missing = int(np.count_nonzero(~usable))
    table = table[usable]
    table = table[(table[:, 0] >= options.start) & (table[:, 0] <= options.stop)][:: options.every]
    if not len(table):
        raise BagError(f"{options.csv} has no complete row between --from {options.start} s and --to {options.stop} s")
    return table, missing


@entry_point
def main(arguments: list[str]) -> int:
    """Make a bag of a CSV file."""
    options = _parser().parse_args(arguments)
    if options.every < 1:
        raise OptionError(f"--every is {options.every}: expected 1 or more")
    table, missing = _table(options)
    names, positions = _joints(table, options)
    stamps = _stamps(table[:, 0], options)
    topic = f"/{options.topic.lstrip('/')}"
    with BagWriter(options.out) as writer:
        for stamp, position in zip(stamps, positions, strict=True):
            writer.write(topic, MESSAGE_TYPE, stamp, serialize_joint_state(names, position, stamp))
        source = {
            "source": options.csv.name,
            "source_sha256": hashlib.sha256(options.csv.read_bytes()).hexdigest(),
            "made_by": f"import_csv {shlex.join(arguments)}",
        }
        writer.close(source)
    duration = (stamps[-1] - stamps[0]) / NANOSECONDS
    print(f"{options.out}: {len(stamps)} samples over {duration:.3f} s on {topic}")
    if missing:
        print(f"{missing} rows lack a number and are left out")
    try:
        trial = load_trial(options.out, TrialOptions(topic=topic))
    except TrialError as error:
        print(f"warning: identify will refuse it: {error}")
    else:
        print(f"zero-input motion: {trial.duration:.3f} s from {trial.start:.3f} s on")
        print(*(f"  {note}" for note in trial.notes), sep="\n", end="\n" if trial.notes else "")
    return 0
