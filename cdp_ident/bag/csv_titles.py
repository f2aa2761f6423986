# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the titles of columns say: which quantity, in which unit."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array

_UNITS = {
    "d": ("day", "days"),
    "h": ("h", "hour", "hours"),
    "min": ("min", "minute", "minutes"),
    "s": ("s", "sec", "secs", "second", "seconds", "sek"),
    "ms": ("ms", "msec", "millis", "milliseconds"),
    "us": ("us", "µs", "μs", "usec", "micros", "microseconds"),
    "ns": ("ns", "nsec", "nanoseconds"),
    "rad": ("rad", "rads", "radian", "radians"),
    "deg": ("deg", "degs", "degree", "degrees", "°", "grad"),
    "mrad": ("mrad", "milliradian", "milliradians"),
    "gon": ("gon", "gons", "gradian", "gradians"),
    "turns": ("turn", "turns", "rev", "revs", "revolutions"),
    "counts": ("count", "counts", "ticks", "inc", "increments"),
    "m": ("m", "metre", "metres", "meter", "meters"),
    "cm": ("cm", "centimetres", "centimeters"),
    "mm": ("mm", "millimetres", "millimeters"),
    "px": ("px", "pix", "pixel", "pixels"),
    "N m": ("nm", "n m", "n*m", "n·m"),
    "mN m": ("mnm", "mn m", "mn*m", "mn·m"),
}
_CANONICAL = {spelling: unit for unit, spellings in _UNITS.items() for spelling in spellings}
_BRACKETS = re.compile(r"^(.*?)\s*[\[({<]\s*([^\])}>]*?)\s*[\])}>]\s*$")
_SUFFIX = re.compile(r"^(.+?)(?:\s*/\s*|\s+in\s+|_|\s+)([^\W\d_]+|°)$")

ANGLE_UNITS = ("rad", "deg", "mrad", "gon", "turns", "counts")

_SECONDS, _NANOSECONDS = re.compile("(.*)secs?"), "{}nanosecs?|{}nsecs?"
TIME, FRAME, INNER, OUTER, CART = "time", "frame", "inner", "outer", "cart"
POINTS = ("pivot_x", "pivot_y", "joint_x", "joint_y", "tip_x", "tip_y")
_TIMES_BY_UNIT = "ms us millis micros"
"""What a column of times may be called by its unit alone."""
_NAMES = {
    TIME: "t time times zeit uhrzeit temps tiempo tempo stamp timestamp elapsed elapsedtime clock sec seconds "
    + _TIMES_BY_UNIT,
    FRAME: "frame frames framenumber frameno frameidx frameindex image bild sample samples index idx",
    CART: "cart cartposition cartpos cartx xcart cartjoint slider sliderposition",
    INNER: "inner innerangle innerjoint innerrod innerarm shoulder upper upperangle upperrod upperarm",
    OUTER: "outer outerangle outerjoint outerrod outerarm elbow lower lowerangle lowerrod lowerarm",
}
_ANGLE = (
    "(?:theta|th|phi|psi|alpha|q|a|θ|φ|angle|ang|winkel|pos|position|joint|jointpos|jointposition|enc|encoder|rod|arm|"
    "link)"
)
_ECHO = 3
"""Columns of a message with joint states before the joints' names."""
_TORQUE = re.compile("tau|torque|effort|moment|nm$")
_LIKE_TORQUE = re.compile("current|pwm|duty|^u[0-3]$|^i[0-3]a$")
_OF_JOINT = re.compile("(.*?)(inner|outer|[0-3])(.*)")
_SAYS_ANGLE = re.compile("angle|ang|winkel|theta|th|phi|psi|alpha|beta|gamma|q|θ|φ|ψ|encoder|enc")
_NO_ANGLE = re.compile(
    "name|packet|seq.*|id|idx|index|line|.*pwm.*|.*duty.*|volt.*|current|amp.*|torque|tau|effort|force|moment|nm|power|temp.*|vel.*|"
    "speed|omega|dot|d?theta.*dot|rate|acc.*|gyro.*|jerk|[xyz]|p[xyz]|sim.*|model.*|pred.*|ref.*|target|set.*|cmd|"
    "command.*|des.*|goal|fit|fitted|err.*|residual.*|status|state|flag|mode|gain|dist.*|height|sec|nanosec|stamp.*|time.*|"
    "likelihood|conf.*|prob.*|score"
)
"""Words in the titles of columns that are not a rod's measured angle."""
_MARKERS = {
    "pivot": "pivot|base|origin|hinge|anchor|p0|marker0",
    "joint": "joint|elbow|middle|mid|knee|p1|marker1",
    "tip": "tip|end|endpoint|effector|bob|p2|marker2",
}


@dataclass(frozen=True)
class Title:
    """The title of a column."""

    text: str
    """As it stands in the file."""
    name: str
    """Without the unit."""
    unit: str
    """As the options of import_csv call it; empty where none is stated or it is not known."""

    @classmethod
    def of(cls, text: str, unit: str = "") -> "Title":
        """Understand a title such as `theta1 [deg]`, `theta1/deg`, `theta1_deg`; `unit` is what stands beneath it."""
        name, stated = text.strip(), unit.strip(" []()")
        match = _BRACKETS.match(name) or _SUFFIX.match(name)
        if match and (is_unit(match[2]) or (match.re is _BRACKETS and not match[2].isdigit())):
            name, stated = match[1].strip(), stated or match[2]
        stated = stated or (name if name.casefold() in _TIMES_BY_UNIT.split() else "")
        return cls(text.strip(), name, _CANONICAL.get(stated.casefold(), ""))

    @property
    def key(self) -> str:
        """The name without case, blanks and signs."""
        return re.sub(r"[\W_]+", "", self.name.casefold())


def is_unit(text: str) -> bool:
    """Return whether a text is a unit, in brackets or not."""
    return text.strip(" []()").casefold() in _CANONICAL


def roles(titles: Sequence[Title]) -> dict[str, int]:
    """Return the places of the columns whose titles tell what they are: of time, frame, inner, outer, cart and POINTS.

    The angles may be counted from 1 or from 0. A role that two columns could have is not given to either.
    """
    keys = [title.key for title in titles]
    patterns = {role: "|".join(names.split()) for role, names in _NAMES.items()}
    first = "1" if any(re.fullmatch(_ANGLE + "2", key) for key in keys) else "0"
    patterns[INNER] += f"|{_ANGLE}{first}"
    patterns[OUTER] += f"|{_ANGLE}{int(first) + 1}"
    for i, (marker, names) in enumerate(_MARKERS.items()):
        for axis in "xy":
            patterns[f"{marker}_{axis}"] = f"(?:{names})(?:pos)?{axis}|{axis}(?:{names})|{axis}{i}"
    found = {}
    for role, pattern in patterns.items():
        places = [place for place, key in enumerate(keys) if re.fullmatch(pattern, key)]
        if len(places) == 1:
            found[role] = places[0]
    return found


def time_before(titles: Sequence[Title], place: int) -> int | None:
    """Return the last column of times before one, as tables have that are put together; None where there is none."""
    is_time = re.compile(f"(?:{'|'.join(_NAMES[TIME].split())})[0-9]?").fullmatch
    return next((before for before in range(place - 1, -1, -1) if is_time(titles[before].key)), None)


def torques(titles: Sequence[Title]) -> list[tuple[int | None, int | None]]:
    """Return the places of torques of motors, of the inner and the outer joint, for each kind that the titles tell.

    Currents and duty cycles, which torques go with, count as such. Of one that stands alone the other is None.
    """
    kinds: dict[tuple[str, str], dict[str, int]] = {}
    for place, title in enumerate(titles):
        key = re.sub("shoulder|upper", "inner", Title(title.text, title.text, "").key)
        key = re.sub("elbow|lower", "outer", key)
        if (_TORQUE.search(key) or _LIKE_TORQUE.search(key)) and (match := _OF_JOINT.fullmatch(key)):
            kinds.setdefault((match[1], match[3]), {})[match[2]] = place
    found: list[tuple[int | None, int | None]] = []
    for places in sorted(kinds.values(), key=len, reverse=True):
        *_, joint = sorted(places)
        if len(places) > 1:
            found.append((places[sorted(places)[-2]], places[joint]))
        else:
            found.append((None, places[joint]) if joint in ("outer", "2", "3") else (places[joint], None))
    return found


def torque_unit(title: Title) -> float | None:
    """Return what a column of torques is in [N m]; None where it is of what they go with, as a current."""
    if title.unit in ("N m", "mN m"):
        return 1.0 if title.unit == "N m" else 1e-3
    return 1.0 if title.text == title.name and _TORQUE.search(title.key) else None


def may_be_angles(titles: Sequence[Title]) -> list[int]:
    """Return the places of columns that may be angles: those whose titles say so, else those that do not deny it."""
    # Of a path, as tools write it, the end.
    names = [re.sub("([a-z])([A-Z])", r"\1 \2", title.name.rpartition("/")[2]) for title in titles]
    words = [set(re.findall(r"[^\W\d_]+", name.casefold())) for name in names]
    possible = [
        place
        for place, title in enumerate(titles)
        if title.unit in ("", *ANGLE_UNITS) and not any(map(_NO_ANGLE.fullmatch, words[place]))
    ]
    said = [place for place in possible if titles[place].unit or any(map(_SAYS_ANGLE.fullmatch, words[place]))]
    return said or possible


def seconds_and_nanoseconds(titles: Sequence[Title]) -> tuple[int, int] | None:
    """Return the places of a stamp's seconds and of their nanoseconds, as ROS parts them; None where there is none."""
    keys = [re.sub(r"[\W_]+", "", title.text.casefold()) for title in titles]
    for place, key in enumerate(keys):
        if match := _SECONDS.fullmatch(key):
            pattern = _NANOSECONDS.format(*[re.escape(match[1])] * 2)
            if others := [other for other, name in enumerate(keys) if re.fullmatch(pattern, name)]:
                return place, others[0]
    return None


def titles_of_echo(values: Array, words: Mapping[int, tuple[int, str]]) -> tuple[Title, ...]:
    """Return the titles of what `ros2 topic echo --csv` writes of joint states, and none of another table.

    Its columns are the stamp's seconds and nanoseconds, the frame, and the joints' names, positions, and maybe
    velocities and efforts. `values` are rows (n, columns), `words` the line and text of columns' first words.
    """
    places = [place for place in sorted(words) if place >= _ECHO]
    names = [words[place][1] for place in places]
    stamped = np.all((values[:, :2] >= 0) & (values[:, :2] % 1 == 0)) and np.all(values[:, 1] < 1e9)
    if not names or not stamped or places != list(range(_ECHO, _ECHO + len(names))):
        return ()
    kinds, rest = divmod(values.shape[1] - _ECHO, len(names))
    if rest or not 2 <= kinds <= 4:
        return ()
    of_kinds = ("{} name", "{}", "{} velocity", "{} effort")[:kinds]
    joints = (kind.format(name) for kind in of_kinds for name in names)
    return tuple(map(Title.of, ("sec", "nanosec", "frame_id", *joints)))
