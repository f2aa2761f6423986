"""Hidden truths: trials of rigs with effects in them that nobody is told of, and the answers.

All of it follows from the kind and the seed: the rig and its size, starts, rate, encoders, noise, and how strong the
effects are. The same truth can be moved by the equations or by a rigid-body engine.
"""

import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference.effects import Effect, Occasion, draw
from reference.encoders import Counter, theta_of
from reference.mechanics import Rig
from reference.pendulum import SYMBOLS, TABLE_2, TABLE_3, TABLE_5
from reference.plant import Plant
from reference.readings import ENGINES, Acting, shown
from reference.visibility import visibility

Array = npt.NDArray[np.float64]

FIT_TRIALS = 2
"""Of the three trials, the first two are to be fitted; the last one is held out."""
SIZES = (0.3, 3.0)
"""Of the rigs, over the paper's."""
RATES = (100, 200, 500, 1000)
"""Samples a second [Hz]."""
COUNTS = (2000, 4000, 8000, 20_000)
"""Counts of an encoder's turn."""
NOISE = (0.05e-3, 2e-3)
"""Standard deviation of what is added to an encoder's angle before it is counted [rad]."""
VISIBLE = (0.4, 40.0)
"""What effects move the angles by beyond imitation, over the noise."""
NOMINAL_ERROR = 0.3
"""Nominal values are off by up to so much."""
_CORRELATED = 0.2
"""In so many truths the noise is correlated."""

_SAME = (
    frozenset({("gravity_tilt", "base"), ("encoder_offset", "inner")}),
    frozenset({("quadratic_friction", "inner"), ("air_drag", "inner")}),
    frozenset({("heavy_cart", "base"), ("cart_on_spring", "base"), ("pivot_compliance", "base")}),
)
"""Names that are right for one another: the same motion, or the same cause described in more detail."""
_BEYOND = {
    "partial_rub": "unknown_torque",
    "magnet": "unknown_torque",
    "rotor_inertia": "",
    "presliding_friction": "coulomb_friction",
    "rod_flex": "",
    "backlash": "",
}
"""What the package has no name for, and what would be a right name of it all the same, if any."""


@dataclass(frozen=True)
class Measured:
    """A trial as a rig measured it."""

    name: str
    time: Array
    """(n,) since the first sample [s]."""
    theta: Array
    """(n, 2) theta1, theta2 [rad]."""


@dataclass(frozen=True)
class Hidden:
    """An effect as it is in one truth."""

    effect: Effect
    strength: float
    """In the effect's unit."""
    visible: float
    """What the paper's model and the truth's other effects cannot imitate of it, over the noise."""

    @property
    def known(self) -> bool:
        """Whether the package has a name for it."""
        return self.effect.name not in _BEYOND

    @property
    def right(self) -> frozenset[tuple[str, str]]:
        """Names and joints, each of which is a right answer."""
        own = (self.effect.name, str(self.effect.joint))
        if not self.known:
            return frozenset({own, (_BEYOND[own[0]], own[1])})
        return next((same for same in _SAME if own in same), frozenset({own}))


@dataclass(frozen=True)
class Truth:
    """Trials, what a user would know beforehand, and what is to be found out."""

    kind: str
    seed: int
    engine: str
    trials: tuple[Measured, ...]
    """Three, of which the last is to be held out."""
    nominal: Mapping[str, float]
    """L and g, and estimates of the rest."""
    values: Mapping[str, float]
    """The rig's physical values."""
    size: float
    """Of the rig over the paper's."""
    rate: int
    """Samples a second [Hz]."""
    counter: Counter
    """Both encoders."""
    hidden: tuple[Hidden, ...]
    floor: float
    """Root mean square of the last trial's errors of both angles [rad]."""


def truth(kind: str, seed: int, engine: str = "equations", visible: float | None = None) -> Truth:
    """Return a hidden truth.

    Args:
        kind: see `kinds`.
        seed: of everything that is random.
        engine: what moves it: "equations" or "mujoco".
        visible: what each effect moves the angles by, over the noise; drawn where not given.

    Raises:
        ValueError: the engine has no element for something of this kind.
    """
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    size = float(np.exp(rng.uniform(*np.log(SIZES))))
    values = _rig(size, rng)
    nominal = {**values, **{s: v * rng.uniform(1.0 - NOMINAL_ERROR, 1.0 + NOMINAL_ERROR) for s, v in values.items()}}
    nominal |= {symbol: values[symbol] for symbol in ("L", "g")}
    starts = [_start(size, rng) for _ in range(FIT_TRIALS + 1)]
    rate = int(rng.choice(RATES))
    times = [np.arange(round(rng.uniform(10.0, 15.0) * rate)) / rate for _ in starts]
    counter = Counter(
        int(rng.choice(COUNTS)),
        float(np.exp(rng.uniform(*np.log(NOISE)))),
        rng.uniform(0.5, 0.9) if rng.random() < _CORRELATED else 0.0,
    )
    durations = [float(moments[-1]) for moments in times[:FIT_TRIALS]]
    occasion = Occasion(values, durations, rng)
    present = [] if kind == "none" else [draw(part, occasion) for part in kind.split("+")]
    hidden = _of_strengths(values, present, starts, durations, counter, visible, rng)

    trials: list[Measured] = []
    floor = 0.0
    for index, (start, moments) in enumerate(zip(starts, times, strict=True)):
        acting = [Acting(h.effect, h.strength) for h in hidden if h.effect.trial in (None, index)]
        joints = shown(Plant(Rig(values)), acting, start, moments, ENGINES[engine])
        theta = theta_of(counter.count(joints, rng))
        floor = float(np.sqrt(np.mean((theta - theta_of(joints)) ** 2)))
        trials.append(Measured(f"{kind} {seed}.{index}", moments, theta))
    return Truth(kind, seed, engine, tuple(trials), nominal, values, size, rate, counter, hidden, floor)


def _of_strengths(
    values: Mapping[str, float], present: Sequence[Effect], starts: Sequence[Array], durations: Sequence[float],
    counter: Counter, visible: float | None, rng: np.random.Generator,
) -> tuple[Hidden, ...]:  # fmt: skip
    """Return the effects with their strengths: by what they are to move, or so that they stop a joint."""
    if not present:
        return ()
    # theta2 is the sum of both encoders' angles.
    noise = counter.error * math.sqrt(1.5)
    hidden = []
    for effect, moved in zip(present, visibility(values, present, starts[:FIT_TRIALS], durations), strict=True):
        drawn = float(np.exp(rng.uniform(*np.log(VISIBLE))))
        strength = min((drawn if visible is None else visible) * noise / moved, effect.largest)
        if effect.stopping is not None:
            strength = effect.stopping
        direction = rng.choice([-1.0, 1.0]) if effect.signed else 1.0
        hidden.append(Hidden(effect, float(direction * strength), float(strength * moved / noise)))
    return tuple(hidden)


def _rig(size: float, rng: np.random.Generator) -> dict[str, float]:
    """Return physical values of a rig so many times the size of the paper's, all others changed by up to 30 %."""
    values = dict(TABLE_5 if rng.random() < 0.5 else TABLE_2)
    heavier = size ** rng.uniform(1.5, 3.0)
    inertia = heavier * size**2
    # A motion's own time goes with the root of the length, and friction is to damp it as much as the paper's.
    scales = dict.fromkeys(SYMBOLS, 1.0) | dict.fromkeys(("m1", "m2", "m0"), heavier)
    scales |= dict.fromkeys(("J1", "J2"), inertia) | dict.fromkeys(("c1", "c2"), inertia / math.sqrt(size))
    scales |= dict.fromkeys(("l1", "l2", "L"), size)
    for symbol in SYMBOLS:
        spread = {"l1": 0.15, "l2": 0.15, "L": 0.0, "g": 0.0}.get(symbol, 0.3)
        values[symbol] *= scales[symbol] * rng.uniform(1.0 - spread, 1.0 + spread)
    return values


def _start(size: float, rng: np.random.Generator) -> Array:
    """Return a start (4,): let go at rest far from hanging, or on its way as the paper's was."""
    if rng.random() < 0.7:
        sides = rng.choice([-1.0, 1.0], 2)
        return np.array([*(math.pi + sides * rng.uniform(0.6, 2.5, 2)), 0.0, 0.0])
    moving = np.array(TABLE_3) * rng.uniform(0.8, 1.2, 4)
    moving[2:] /= math.sqrt(size)
    return moving
