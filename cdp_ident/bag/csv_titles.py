"""What the titles of columns say: which quantity, in which unit."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

_UNITS = {
    "s": ("s", "sec", "secs", "second", "seconds", "sek"),
    "ms": ("ms", "msec", "millis", "milliseconds"),
    "us": ("us", "µs", "μs", "usec", "micros", "microseconds"),
    "ns": ("ns", "nsec", "nanoseconds"),
    "rad": ("rad", "rads", "radian", "radians"),
    "deg": ("deg", "degs", "degree", "degrees", "°", "grad"),
    "turns": ("turn", "turns", "rev", "revs", "revolutions"),
    "counts": ("count", "counts", "ticks", "inc", "increments"),
    "m": ("m", "metre", "metres", "meter", "meters"),
    "cm": ("cm", "centimetres", "centimeters"),
    "mm": ("mm", "millimetres", "millimeters"),
    "px": ("px", "pix", "pixel", "pixels"),
}
_CANONICAL = {spelling: unit for unit, spellings in _UNITS.items() for spelling in spellings}
_BRACKETS = re.compile(r"^(.*?)\s*[\[({<]\s*([^\])}>]*?)\s*[\])}>]\s*$")
_SUFFIX = re.compile(r"^(.+?)(?:\s*/\s*|\s+in\s+|_|\s+)([^\W\d_]+|°)$")

TIME, FRAME, INNER, OUTER, CART = "time", "frame", "inner", "outer", "cart"
POINTS = ("pivot_x", "pivot_y", "joint_x", "joint_y", "tip_x", "tip_y")
_NAMES = {
    TIME: "t time times zeit temps tiempo tempo timestamp stamp elapsed elapsedtime seconds sec clock",
    FRAME: "frame frames framenumber frameno frameidx frameindex image bild sample samples index idx",
    CART: "cart cartposition cartpos cartx xcart cartjoint slider sliderposition",
    INNER: "inner innerangle innerjoint innerrod innerarm shoulder upper upperangle upperrod upperarm",
    OUTER: "outer outerangle outerjoint outerrod outerarm elbow lower lowerangle lowerrod lowerarm",
}
_ANGLE = (
    "(?:theta|th|phi|psi|alpha|q|a|θ|φ|angle|ang|winkel|pos|position|joint|jointpos|jointposition|enc|encoder|rod|arm|"
    "link)"
)
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
        if match and (match.re is _BRACKETS or is_unit(match[2])):
            name, stated = match[1].strip(), stated or match[2]
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
