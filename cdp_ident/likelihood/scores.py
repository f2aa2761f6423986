# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects that a model does not have would do for it, from its own sweep: no fit is needed for that.

Each is put into the model with no strength; what readings say of it, once the model's own values, states and impulses
are estimated, is a small linear problem (Rao's score test; with what is known beforehand it gives the evidence that the
effect would have). What happens at one instant is looked for at every node: an impulse, and lost counts (de Jong and
Penzer, Diagnosing shocks in time series, J. Am. Stat. Assoc. 93, 1998).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.bounded import UNDETERMINED, minimum_within_limits
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.prior import known_of, typical
from cdp_ident.likelihood.reduction import Part, inverse_of, memory_for_rows, most_likely_change, reduced
from cdp_ident.likelihood.sweeps import backwards, forwards
from cdp_ident.likelihood.swing import Linearised, Swing
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.effect import JOINTS, Effect, Joint
from cdp_ident.model.layout import most_directions

_OVERFLOWS = 1e100
"""Sensitivities beyond this cannot be computed; what has them has no score."""
_SEEN = 1e-6
"""A strength is seen where the readings say more of it than this share of what the model's own values can imitate, and
of what is known beforehand."""
_PART = 1e-6
"""An unknown torque has a part in an impulse from this share on."""
_SEEN_AT_ONCE = 1e-6
"""A shock is looked for where the readings say more of it than this share of what they say of most."""
PLACES = 3
"""So many places, or instants, are tried of an effect that acts at one: its score may be better at another one, where
unknown torques hide it, or what happens lies between two nodes."""
_APART = 4
"""Instants are at least so many nodes apart."""
_BINS, _STEPS_OF_PERIOD = 2**14, 3.0
"""Parts of a turn with which residuals' spectrum over the angle is computed, and least steps of an encoder in a period
of an error of it."""
SHAPES = (1.0, 0.25, 4.0)
"""An effect whose strength is not seen at one value of its shape alone is tried with the first one so many times the
typical value."""
WIDTHS = (1.0, 0.5)
"""What acts near a place is looked for with so many times its typical width: one that is wide does not get narrower
where unknown torques follow what is narrow."""


@dataclass(frozen=True)
class Score:
    """What an effect would do for a model."""

    active: ActiveEffect
    misfit: float
    """By how much the misfit would change: below zero, the model with it is the more likely one."""
    gain: float
    """By how much the sum of squares would fall."""
    values: Array
    """(k,) the values that its parameters would have."""
    change: Array
    """(unknowns,) by how much it would change the model's values."""
    spread: Array
    """(unknowns, unknowns) what its own uncertainty would add to the covariance of these."""
    freedom: int = 1
    """How many strengths it has."""
    elsewhere: tuple[Array, ...] = ()
    """(k,) values at other places or instants, the most promising first, of an effect that acts at one."""


@dataclass(frozen=True)
class Shock:
    """What happens at one instant of a trial."""

    gain: float
    """By how much the sum of squares would fall."""
    trial: int
    time: float
    """[s]"""
    size: float
    """Of an impulse over A22 [1/s], or of the counts that were lost [rad]."""
    elsewhere: tuple[tuple[float, float], ...] = ()
    """Sizes and times of others in this trial, the best first."""


def scores(found: WholeSwings, candidates: Sequence[tuple[ActiveEffect, Array]]) -> list[Score]:
    """Return what each of some effects would do for a model, the best first.

    Args:
        found: the model, fitted.
        candidates: effects without strength, each with its values (k,), see `beginnings`; curves have their smoothness.
    """
    scored = [score for some in _in_turns(found, candidates) for score in _scores(found, some)]
    return sorted(scored, key=lambda score: score.misfit)


def _in_turns(
    found: WholeSwings, candidates: Sequence[tuple[ActiveEffect, Array]]
) -> Iterator[list[tuple[ActiveEffect, Array]]]:
    """Yield candidates for whose parameters together there is room; each that brings states of its own alone."""
    most = most_directions(found.model.states) - found.model.states - len(found.values)
    some, room = list[tuple[ActiveEffect, Array]](), most
    for candidate, beginning in candidates:
        states, size = candidate.effect.states, int(np.sum(candidate.strengths))
        if some and candidate.effect.curve and candidate.effect == some[-1][0].effect:
            size = 0  # another smoothness of the same curve
        if some and (states or some[-1][0].effect.states or size > room):
            yield some
            some, room = [], most
        if states + size <= room:
            some.append((candidate, beginning))
            room -= size
    if some:
        yield some


def _scores(found: WholeSwings, candidates: Sequence[tuple[ActiveEffect, Array]]) -> Iterator[Score]:
    model, values, unit = found.model, found.values, found.recorded.time_unit
    own, places = len(values), dict[tuple[str, int | None, bytes], Indices]()
    wanted, begins = list[Mask]([np.ones(own, dtype=bool)]), list[int]()
    for candidate, beginning in candidates:
        key, first = (candidate.effect.key, candidate.trial, beginning.tobytes()), len(values)
        if key in places:
            continue  # another smoothness of the same curve
        model, values = model.with_effect(candidate), np.concatenate([values, beginning])
        places[key] = first - own + np.flatnonzero(candidate.strengths)
        wanted.append(candidate.strengths)
        begins += [first - own] * len(beginning)
    states = [_of_size(of, found.model.states, model.states) for of in found.states]
    linear = [
        _without_overflow(swing.linearised(model, values, of, np.concatenate(wanted)))
        for swing, of in zip(found.recorded.swings, states, strict=True)
    ]
    rows = np.zeros((own, len(values) + 1))
    rows[:, [*range(own), len(values)]] = found.known.rows(found.values)
    left = reduced(model, rows, found.recorded.swings, linear, states, found.noise, own, np.array([*begins, 0]))
    of_own, across = left.of_values[:, :own], left.of_values[:, own:]
    imitated = -inverse_of(of_own)[0] @ across
    for candidate, beginning in candidates:
        strong = np.flatnonzero(candidate.strengths)
        precision = known_of(candidate, unit)[0][np.ix_(strong, strong)]
        at = places[candidate.effect.key, candidate.trial, beginning.tobytes()]
        alone = np.diag(left.others)[at]
        seen = alone > _SEEN * np.maximum(np.sum(across[:, at] ** 2, axis=0), np.diag(precision))
        if not np.any(seen):
            continue
        at, strong, precision = at[seen], strong[seen], precision[np.ix_(seen, seen)]
        chosen = [candidate.fitted[k] for k in strong]
        lower, upper = (np.array([getattr(parameter, end) for parameter in chosen]) for end in ("lower", "upper"))
        curvature, slope = left.others[np.ix_(at, at)], -left.others[at, -1]
        whole = curvature + precision
        scale = 1.0 / np.sqrt(np.diag(whole))
        sizes, vectors = np.linalg.eigh(whole * np.outer(scale, scale))
        roots = scale[:, None] * vectors / np.sqrt(np.maximum(sizes, UNDETERMINED * sizes[-1]))
        inverse = roots @ roots.T
        strengths = inverse @ slope
        if np.any((strengths < lower) | (strengths > upper)):
            strengths = minimum_within_limits(whole, slope, lower, upper)
        gain = float(2.0 * strengths @ slope - strengths @ whole @ strengths)
        if not np.isfinite(gain) or gain <= 0.0:
            continue
        # What the priors' and the posterior's volumes do is left as it is where no strength is at a limit.
        logarithm = np.sum(np.log(np.maximum(sizes, UNDETERMINED * sizes[-1]) / scale**2))
        logarithm -= np.linalg.slogdet(precision)[1]
        all_values = beginning.copy()
        all_values[strong] = strengths
        by = imitated[:, at]
        yield Score(
            candidate,
            float(logarithm) - gain,
            gain,
            all_values,
            by @ strengths,
            by @ inverse @ by.T,
            len(strengths),
        )


def begun(effects: Iterable[Effect], unit: float) -> list[tuple[ActiveEffect, Array]]:
    """Return effects without strength, each with values (k,) of its shape parameters where it may show."""
    return [(active, values) for active in map(ActiveEffect, effects) for values in beginnings(active, unit)]


def beginnings(active: ActiveEffect, unit: float) -> Iterator[Array]:
    """Yield values (k,) of an effect without strength: its shape parameters are where it says, or typical."""
    fitted = active.fitted
    usual = np.array([typical(parameter, unit) if parameter.shape else 0.0 for parameter in fitted])
    shapes = [k for k, parameter in enumerate(fitted) if parameter.shape]
    if not shapes:
        yield usual
        return
    if active.effect.is_local:
        place = next(k for k in shapes if fitted[k].begins)
        widths = [k for k in shapes if fitted[k].resolves]
        for width in WIDTHS if widths else (1.0,):
            for begin in fitted[place].begins:
                values = usual.copy()
                values[widths] *= width
                values[place] = float(begin)
                yield values
        return
    one = shapes[0]
    for factor in SHAPES:
        values = usual.copy()
        values[one] = np.clip(factor * values[one], fitted[one].lower, fitted[one].upper)
        yield values


def repeated(found: WholeSwings, effects: Iterable[Effect]) -> Iterator[Score]:
    """Yield the scores of errors that repeat many times a turn of their encoder, each at its best number of periods.

    Over the angle, residuals have a spectrum; of each number of periods it gives the sine and cosine that fit best.

    Args:
        found: the model.
        effects: their parameters are a sine, a cosine and the number of periods.
    """
    own = len(found.values)
    for effect in effects:
        joint, active = JOINTS.index(effect.joint), ActiveEffect(effect)
        angle = np.concatenate([swing.readings[:, joint] for swing in found.recorded.swings])
        left = np.concatenate([linear.residuals[:, joint] for linear in found.linear])
        counts = np.concatenate([swing.counts[:, joint] for swing in found.recorded.swings])
        counts = counts / found.noise.encoders[joint] ** 2
        lower, upper = active.fitted[-1].lower, active.fitted[-1].upper
        # Rounding repeats as often as an encoder has steps.
        step = found.recorded.steps[joint]
        most = min(upper, 2.0 * np.pi / step / _STEPS_OF_PERIOD if step > 0.0 else upper)
        periods = np.arange(int(np.ceil(lower)), int(most) + 1)
        place = np.round((angle - (np.pi if joint == 0 else 0.0)) * (_BINS / (2.0 * np.pi))).astype(np.int64) % _BINS
        of_left, of_counts = (np.fft.rfft(np.bincount(place, of, _BINS)) for of in (counts * left, counts))
        slopes = np.stack([of_left[periods].imag, -of_left[periods].real], axis=1)
        total, twice = of_counts[0].real, of_counts[2 * periods]
        known = known_of(active, found.recorded.time_unit)[0][:2, :2]
        curvatures = 0.5 * np.array([[total - twice.real, -twice.imag], [-twice.imag, total + twice.real]])
        whole = curvatures.transpose(2, 0, 1) + known
        strengths = np.linalg.solve(whole, slopes[..., None])[..., 0]
        gains = np.sum(strengths * slopes, axis=1)
        if not len(gains):
            continue
        best = int(np.argmax(gains))
        logarithm = np.linalg.slogdet(whole[best])[1] - np.linalg.slogdet(known)[1]
        values = np.array([*strengths[best], periods[best]])
        nothing = np.zeros(own), np.zeros((own, own))
        yield Score(active, float(logarithm - gains[best]), float(gains[best]), values, *nothing, freedom=2)


def shocks(found: WholeSwings) -> tuple[dict[Joint, Shock], dict[Joint, Shock]]:
    """Return the impulse on each rod and the lost counts of each encoder that would do most for a model."""
    impulses, slips = dict[Joint, Shock](), dict[Joint, Shock]()
    whole = reduced(
        found.model, found.known.rows(found.values), found.recorded.swings, found.linear, found.states, found.noise
    )
    change, covariance, _ = most_likely_change(found.model, found.values, whole.of_values)
    for place, (swing, linear, states, part) in enumerate(
        zip(found.recorded.swings, found.linear, found.states, whole.parts, strict=True)
    ):
        tails = found.noise.tails_of(place)
        of_swing = _of_swing(found, swing, linear, states, part, change, covariance, tails)
        for best, each in zip((impulses, slips), of_swing, strict=True):
            for joint, shock in each.items():
                if joint not in best or shock.gain > best[joint].gain:
                    best[joint] = shock
    return impulses, slips


def _of_swing(
    found: WholeSwings,
    swing: Swing,
    linear: Linearised,
    states: Array,
    part: Part,
    change: Array,
    covariance: Array,
    tails: Array | None,
) -> tuple[dict[Joint, Shock], dict[Joint, Shock]]:
    """Return the best impulses and lost counts of a swing."""
    # What an encoder shows from a node on is off by two candidates more, of which no other unknown knows.
    shifted = linear._replace(
        transitions=_widened(linear.transitions), slopes=_widened(linear.slopes, np.eye(2)), columns=linear.columns
    )
    whitened = found.noise.whitened(swing, shifted, tails)
    (nodes, n, d), own = whitened.transitions.shape, whitened.transitions.shape[2] - 2
    triangles, rows = np.empty((nodes, own, d + 1)), np.empty((nodes, 2, d + 3))
    left = np.empty((nodes, 3, 3))
    backwards(whitened, rows, triangles, left, np.zeros(3, dtype=np.int64), memory_for_rows(swing, own, d))
    deviations, spreads = np.empty((nodes, own)), np.empty((nodes, own, own))
    deviations[0], spreads[0] = part.first_node(change[linear.columns], covariance, linear.columns)
    torques = np.zeros((nodes, 2, 2))
    forwards(whitened, rows, deviations, spreads, torques, np.empty((4, 2)), np.empty((2 * n + 2, own + 1)))
    times = swing.begin + swing.node_times
    tails = np.ones((nodes, 2)) if tails is None else tails
    # A torque on the outer rod alone is one in both joints; where the base moves, either is a part of that.
    on_rods = np.linalg.pinv(whitened.pushes) @ linear.pushes @ [[1.0, 1.0], [0.0, 1.0]]
    return (
        _impulses(swing, times, rows, spreads, torques[:, 0], whitened.sizes, tails, found.noise, on_rods),
        _slips(swing, times, triangles, left, deviations, spreads),
    )


def _slips(
    swing: Swing, times: Array, triangles: Array, left: Array, deviations: Array, spreads: Array
) -> dict[Joint, Shock]:
    own = deviations.shape[1]
    of_own, of_slip = triangles[:, :, :own], triangles[:, :, own : own + 2]
    rest = np.einsum("kij,kj->ki", of_own, deviations) + triangles[:, :, -1]
    slope = np.einsum("kio,ki->ko", of_slip, rest) + left[:, :2, 2]
    across = np.einsum("kio,kij->koj", of_slip, of_own)
    curvature = np.einsum("kio,kio->ko", of_slip, of_slip) + np.einsum("koo->ko", left[:, :2, :2])
    curvature -= np.einsum("koj,kjl,kol->ko", across, spreads, across)
    found = {}
    for place, joint in enumerate(JOINTS):
        found[joint] = _best(swing, times, slope[:, place], curvature[:, place])
    return found


def _impulses(
    swing: Swing,
    times: Array,
    rows: Array,
    spreads: Array,
    torques: Array,
    sizes: Array,
    tails: Array,
    noise: Noise,
    on_rods: Array,
) -> dict[Joint, Shock]:
    """Return the best impulse on each rod, of which `on_rods` (nodes, 2, 2) is what it is of the unknown torques."""
    own, inverse = spreads.shape[1], np.zeros((len(times), 2, 2))
    inverse[:, 0, 0], inverse[:, 1, 1] = 1.0 / rows[:, 0, 0], 1.0 / rows[:, 1, 1]
    inverse[:, 0, 1] = -rows[:, 0, 1] * inverse[:, 0, 0] * inverse[:, 1, 1]
    gains = inverse @ rows[:, :, 2 : 2 + own]
    covariances = gains @ spreads @ gains.transpose(0, 2, 1) + inverse @ inverse.transpose(0, 2, 1)
    precision = sizes[..., None] ** -2.0 * np.eye(2)
    curvatures = precision - precision @ covariances @ precision
    found, regained = {}, noise.regained(tails)
    for place, joint in enumerate(JOINTS):
        torque = on_rods[:, :, place]
        slope = -np.sum(torques * sizes**-2.0 * torque, axis=1)
        curvature = np.einsum("ki,kij,kj->k", torque, curvatures, torque)
        has_part = np.abs(torque) > _PART
        back, times_as_large = np.sum(regained * has_part, axis=1), np.max(np.where(has_part, tails, 1.0), axis=1)
        of_all = times[:-1] + swing.spacing, slope[:-1], curvature[:-1], back[:-1], times_as_large[:-1] ** 2
        found[joint] = _best(swing, *of_all)
    return found


def _best(
    swing: Swing,
    times: Array,
    slope: Array,
    curvature: Array,
    regained: Array | float = 0.0,
    follows: Array | float = 1.0,
) -> Shock:
    """Return the best shock, at `times` (nodes,).

    Args:
        swing: what was measured.
        times: (nodes,) of each.
        slope: (nodes,) of the sum of squares by its size.
        curvature: (nodes,) likewise.
        regained: (nodes,) by how much more the misfit falls.
        follows: (nodes,) by how much a torque that is unknown makes the curvature smaller there.
    """
    shown = curvature * follows
    seen = shown > _SEEN_AT_ONCE * max(float(np.median(shown)), np.finfo(float).tiny)
    gain = np.where(seen, slope**2 / np.where(seen, curvature, 1.0) + regained, 0.0)
    if not len(gain):
        return Shock(0.0, swing.trial, swing.begin, 0.0)
    chosen, left = list[int](), gain.copy()
    while len(chosen) < PLACES and (not chosen or left.max() > 0.0):
        chosen.append(int(np.argmax(left)))
        left[max(chosen[-1] - _APART + 1, 0) : chosen[-1] + _APART] = 0.0
    shocks = [(float(-slope[k] / curvature[k]), float(times[k])) for k in chosen]
    (size, time), others = shocks[0], tuple(shocks[1:])
    return Shock(float(gain[chosen[0]]), swing.trial, time, size, others)


def _widened(of: Array, by: Array | float = 0.0) -> Array:
    """Return derivatives (…, d) with two directions more, in which they are what is given."""
    return np.ascontiguousarray(np.concatenate([of, np.broadcast_to(by, (*of.shape[:-1], 2))], axis=-1))


def _of_size(states: Array, before: int, after: int) -> Array:
    """Return states (nodes, before …) with zeros for those that effects bring."""
    return np.concatenate([states[:, :before], np.zeros((len(states), after - before)), states[:, before:]], axis=1)


def _without_overflow(linear: Linearised) -> Linearised:
    """Return a linearised swing without sensitivities that cannot be computed."""
    parts = {name: np.asarray(getattr(linear, name)) for name in ("transitions", "slopes")}
    return linear._replace(**{n: np.where(np.abs(of) < _OVERFLOWS, of, 0.0) for n, of in parts.items()})
