# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make a bag of a CSV file: `import_csv CSV --out DIR …`."""

import argparse
import math
from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, get_args

from cdp_ident.command_line import ArgumentParser, entry_point, within
from cdp_ident.errors import OptionError
from cdp_ident.start import loading
from cdp_ident.trial.options import OuterAngle, ScaleFrom, TrialOptions, Unit, Zero
from cdp_ident.user_input import quoted

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}
ANGLE_UNITS: dict[str, Unit] = {
    **{"rad": "radians", "deg": "degrees", "mrad": "milliradians", "gon": "gradians"},
    "turns": "turns",
}
LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_POSITIVE = within(1e-9, 1e12)
_SIGN: dict[str, Any] = {"type": int, "choices": (1, -1), "help": "(default: 1, towards +x)"}
_OFFSET: dict[str, Any] = {"type": float, "metavar": "RAD", "help": "added to the angle: a zero elsewhere"}
_SCALE: dict[str, Any] = {
    **{"type": float, "metavar": "FACTOR", "help": "reading over angle, if counts per turn are wrong"}
}
MEANINGS: dict[str, dict[str, Any]] = {
    "zero": {"choices": get_args(Zero), "help": "(default: upright)"},
    "outer_angle": {"choices": get_args(OuterAngle), "help": "(default: relative)"},
    **{"inner_sign": _SIGN, "outer_sign": _SIGN, "inner_offset": _OFFSET, "outer_offset": _OFFSET},
    **{"inner_scale": _SCALE, "outer_scale": _SCALE},
    "scale_from": {"choices": get_args(ScaleFrom), "help": "where readings with a factor are right (default: hanging)"},
}
"""What the user may say about angles, but not about points: which options of a trial, and how they are given."""


@dataclass(frozen=True)
class TypedOptions(TrialOptions):
    """Options as the user types them on the command line."""

    insist = "--anyway writes the bag all the same"
    all_settable = False

    def called(self, option: str) -> str:
        """Return what an option is called there."""
        name = {"start": "from", "stop": "to", "inner_joint": "inner", "outer_joint": "outer"}.get(option, option)
        return f"--{name.replace('_', '-')}"

    def setting(self, option: str, value: object) -> str:
        """Return how it is set there."""
        return f"{self.called(option)} {value}"


_EPILOG = """
The bag holds sensor_msgs/JointState in the conventions of cdp_ident: radians and metres, zero upright, positive
towards +x, inner_joint, outer_joint (relative to the inner rod) and cart_joint. Titles and units in the file are
used; everything else is set by options, and assumptions are printed. They are checked against the physics of the
motion: where they contradict it, no bag is written, and the exit code is 2.

example: a recording at 1 kHz with absolute angles, of which every fifth sample from 10 s on is taken
  import_csv swing.csv.gz --out swing --outer-angle absolute --from 10 --every 5
example: encoder counts in columns 1 and 2, zero where the rods hang, milliseconds in column 0
  import_csv log.txt --out swing --time-unit ms --angle-unit counts --counts-per-turn 8000 --zero hanging
example: markers on a film of 240 frames a second, in pixels, of a rig with 17 cm between its joints
  import_csv tracked.csv --out swing --rate 240 --points pivot_x pivot_y joint_x joint_y tip_x tip_y --length 0.17
"""


def unit_in(known: Collection[str], unit: str, path: Path, option: str) -> str:
    """Return a unit that is one of those known, or raise OptionError with the option that sets it."""
    if unit not in known:
        raise OptionError(f"{path}: {option} in {unit}? Give --{option}-unit")
    return unit


@entry_point
def main(arguments: list[str]) -> None:
    """Make a bag of a CSV file."""
    options = _parser().parse_args(arguments)
    if options.delimiter is not None and len(options.delimiter) != 1:
        raise OptionError(f"--delimiter is {quoted(options.delimiter)}: expected one character")
    counts = options.counts_per_turn or []
    if options.angle_unit != "counts" and counts:
        raise OptionError("--counts-per-turn goes with --angle-unit counts")
    if options.angle_unit == "counts" and len(counts) not in (1, 2):
        raise OptionError("--angle-unit counts needs --counts-per-turn with one or two numbers")
    if options.cart_unit == "counts" and not options.counts_per_metre:
        raise OptionError("--cart-unit counts needs --counts-per-metre")
    if options.points is not None:
        if len(options.points) not in (0, 4, 6):
            raise OptionError(
                f"--points has {len(options.points)} columns: expected x and y of pivot, joint and tip, or of joint "
                "and tip, or none where the titles tell them"
            )
        if options.inner or options.outer or options.angle_unit:
            raise OptionError("--points takes the angles' place: --inner, --outer and --angle-unit do not go with it")
    with loading("import_csv"):
        from cdp_ident.commands._csv_bag import make_bag
    make_bag(options, arguments)


def _parser() -> ArgumentParser:
    parser = ArgumentParser(
        "import_csv", "Make a rosbag2 bag, which identify takes, of a CSV file with measured angles or points.", _EPILOG
    )
    parser.add_argument("csv", type=Path, metavar="CSV", help="the file, also compressed with gzip")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the new bag; must not exist")
    columns = parser.add_argument_group("columns, by title or by number counted from 0 (default: as the titles tell)")
    columns.add_argument("--time", metavar="COLUMN", help="time (else: 0)")
    columns.add_argument("--inner", metavar="COLUMN", help="angle of the inner rod (else: the first after the time)")
    columns.add_argument("--outer", metavar="COLUMN", help="angle of the outer rod (else: the second)")
    columns.add_argument("--cart", metavar="COLUMN", help="position of the cart (else: it is at rest)")
    columns.add_argument(
        "--points",
        nargs="*",
        metavar="COLUMN",
        help="instead of angles, x and y of pivot, joint and tip, or of joint and tip alone if the pivot is at rest",
    )
    columns.add_argument("--delimiter", metavar="SIGN", help="between columns (default: found)")
    columns.add_argument("--decimal", choices=(".", ","), help="decimal sign (default: found)")
    units = parser.add_argument_group("units (default: as the titles tell, else found and printed)")
    units.add_argument("--time-unit", choices=TIME_UNITS)
    units.add_argument(
        "--rate", type=_POSITIVE, metavar="HZ", help="rows a second, for a file without times or with frame numbers"
    )
    units.add_argument("--angle-unit", choices=(*ANGLE_UNITS, "counts"))
    units.add_argument(
        "--counts-per-turn", type=_POSITIVE, nargs="+", metavar="N", help="encoder counts, of both joints or of each"
    )
    units.add_argument("--cart-unit", choices=(*LENGTH_UNITS, "counts"), help="(else: m)")
    units.add_argument("--counts-per-metre", type=_POSITIVE, metavar="N", help="encoder counts of the cart")
    units.add_argument("--points-unit", choices=("px", *LENGTH_UNITS), help="(else: px)")
    meaning = parser.add_argument_group("what the numbers mean")
    for name, how in (MEANINGS | {"cart_sign": _SIGN}).items():
        meaning.add_argument(f"--{name.replace('_', '-')}", **how)
    meaning.add_argument("--y-axis", choices=("down", "up"), help="of points (default: down in px, else up)")
    meaning.add_argument(
        "--lean", type=within(-180, 180), default=0.0, metavar="DEG", help="added to both angles: a camera's lean"
    )
    meaning.add_argument(
        "--length", type=_POSITIVE, metavar="M", help="between the joints; checked against the motion [m]"
    )
    choice = parser.add_argument_group("what is taken")
    choice.add_argument(
        "--from", dest="start", type=float, default=-math.inf, metavar="S", help="file's time [s] to begin at"
    )
    choice.add_argument(
        "--to", dest="stop", type=float, default=math.inf, metavar="S", help="file's time [s] to end at"
    )
    choice.add_argument(
        "--every", type=within(1, 10**9, int), default=1, metavar="N", help="take every Nth sample (default: 1)"
    )
    choice.add_argument("--anyway", action="store_true", help="write the bag even if identify will refuse it")
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
        return round(float(text) * 1e9)
    except (ValueError, OverflowError):
        pass
    try:
        moment = datetime.fromisoformat(text.replace("Z", "+00:00"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f"{text!r} is neither a date such as 2024-05-31T12:00:00Z nor seconds"
        ) from error
    moment = moment if moment.tzinfo else moment.replace(tzinfo=timezone.utc)
    return round(moment.timestamp() * 1e6) * 1000
