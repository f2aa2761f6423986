# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models that differ from one by an effect: what may be added, what may take an effect's place, what may go."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.prior import typical
from cdp_ident.likelihood.reduction import information_of
from cdp_ident.likelihood.scores import PLACES, SHAPES, Score, beginnings, begun, repeated, scores, shocks
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import JOINTS, Effect, exclude_each_other
from cdp_ident.model.formulas.language import COEFFICIENTS
from cdp_ident.model.formulas.syntax import evaluated
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.time_grid import between
from cdp_ident.tracing.odds import ambiguity, unlikelihood

FEW = 4
"""So many of the most promising additions are fitted at a step: of effects that imitate one another they are enough."""
_BENDS = (1e-3, 1e-2, 1e-1)
"""Smoothness of curves, from which their score chooses; see `ActiveEffect.bend`."""
_PROMISES = -2.0
"""An effect is tried where its score changes the misfit by less than this. The odds against it are not in that: where
torques or autocorrelated noise stand in for it, a score is too small."""
_ALTERNATIVES = 0.9
"""Another effect is tried in the place of one if its score is at least this share of that: of those that came within
odds of 10^5 it was all of it."""

_AHEAD = np.array([1.0, 2.0, 4.0])
"""What acts at a place begins so many times as long before an impulse as that lasts, in standard deviations, ..."""
_SHORT = 0.05
"""... which for one without a duration is so many time units."""


@dataclass(frozen=True)
class Neighbour:
    """A model to be fitted, and where to begin."""

    model: MotionModel
    values: Array
    """(unknowns,)"""
    what: tuple[str, ...]
    """Keys of the effects that it has more, or has no longer."""
    origin: WholeSwings
    """The fitted model whose states and noise it begins with."""
    again: bool = False
    """Whether it is fitted even if it was before, from elsewhere."""
    unscored: bool = False
    """Whether no score speaks for it: it is fitted to the end if a few steps make the model more probable."""

    @property
    def states(self) -> list[Array]:
        """(nodes, states) of each swing to begin with; those that other effects bring are zero."""
        return _states_of(self.origin, self.model)


def first(neighbours: Iterable[Neighbour]) -> list[Neighbour]:
    """Return the first neighbours, of a few effects."""
    chosen = dict[tuple[str, ...], list[Neighbour]]()
    for each in neighbours:
        if each.what not in chosen and len(chosen) == FEW:
            break
        chosen.setdefault(each.what, []).append(each)
    return [each for of_effect in chosen.values() for each in of_effect]


def additions(found: WholeSwings, scored: Sequence[Score]) -> Iterator[Neighbour]:
    """Yield the models with one effect more, the most promising first.

    Args:
        found: a model.
        scored: what effects would do for it, see `scores_of`.
    """
    best_named = min((score.misfit for score in scored if score.active.effect.curve is None), default=0.0)
    tried = set[tuple[str, str]]()
    for score in scored:
        # A nonparametric torque takes long to fit: one is tried, and where names say less. Harmonics are one effect.
        effect = score.active.effect
        is_curve = effect.curve is not None
        one_of_many = (effect.name, "" if is_curve else effect.joint)
        worth = one_of_many not in tried and (not is_curve or score.misfit < best_named)
        if is_curve or effect.harmonic:
            tried.add(one_of_many)
        if worth and score.misfit + ambiguity(score.active, found.recorded) < _PROMISES:
            yield from _holding_both(found, score)
            yield with_one_more(found, score.active, score.values)
            for values in score.elsewhere:
                yield replace(with_one_more(found, score.active, values), again=True)


def _holding_both(found: WholeSwings, score: Score) -> Iterator[Neighbour]:
    """Yield models with one effect in the place of one that a model has and of another one beside it.

    Two impulses may be one that lasts, and an encoder that is late and filtered beyond that is behind a filter.
    """
    kind = score.active.effect.name, score.active.effect.joint
    for index, active in enumerate(found.model.effects):
        for form in _extended([active.effect]):
            if (form.name, form.joint) != kind or form == score.active.effect or active.trial != score.active.trial:
                continue
            if form.at_an_instant:
                (one, at), (other, also_at) = found.values[found.model.places(index)].tolist(), score.values.tolist()
                begins = [[one + other, 0.5 * (at + also_at), 0.5 * abs(at - also_at)]]
            else:
                begins = [*beginnings_of(found, _by_name(found, index), form)]
            for values in begins:
                yield replace(_instead(found, index, replace(active, effect=form), values), again=True)


def lasts(active: ActiveEffect) -> bool:
    """Return whether an effect acts in all trials, at all times and places, and brings no states of its own."""
    return active.trial is None and not active.effect.brings_states and not active.effect.is_local


def scores_of(found: WholeSwings, named_only: bool, lasting: bool = False) -> list[Score]:
    """Return what each effect would do for a model, its best form alone, the best first with its odds.

    Args:
        found: the model.
        named_only: whether nonparametric torques are left out.
        lasting: whether effects alone are asked for that last, see `lasts`.
    """
    present, unit = [active.effect for active in found.model.effects], found.recorded.time_unit
    allowed = [e for e in known_effects() if not any(_in_the_way(e, other) for other in present)]
    # Beside what it contains, an extended model shows by what it has more.
    extended, more = _extended(present), bool(np.any(found.leaves_more)) and not lasting
    plain = [e for e in allowed if not e.contains or e.brings_states] + extended
    ready = [e for e in dict.fromkeys(plain) if e.has_score and (more or not (e.brings_states or e.is_local))]
    scored = [*scores(found, begun(ready, unit)), *repeated(found, [e for e in allowed if e.repeats])]
    if more:
        scored += _differences(found)
    if not named_only:
        curves = [e for e in allowed if e.curve and found.leaves_more[JOINTS.index(e.joint)]]
        scored += scores(found, [(replace(of, bend=bend), none) for of, none in begun(curves, unit) for bend in _BENDS])
    if not lasting:
        scored += _at_instants(found)
    best = dict[tuple[str, int | None], Score]()
    for score in sorted(scored, key=lambda one: one.misfit + unlikelihood(one.active, found.recorded)):
        key = score.active.effect.key, score.active.trial
        kept = best.setdefault(key, score)
        if score is not kept and kept.active.effect.is_local and len(kept.elsewhere) < PLACES - 1:
            best[key] = replace(kept, elsewhere=(*kept.elsewhere, score.values))
    return list(best.values())


def _in_the_way(one: Effect, other: Effect) -> bool:
    """Return whether a model has at most one of two effects: a curve over an angle contains all that depends on it."""
    return exclude_each_other(one, other) or (
        one.joint == other.joint
        and any(a.curve is not None and a.curve.over == "angle" and b.of_angle for a, b in ((one, other), (other, one)))
    )


def _extended(present: Sequence[Effect]) -> list[Effect]:
    """Return effects that contain one of a model's."""
    return [effect for effect in known_effects() for one in present if effect.extends(one)]


def _differences(found: WholeSwings) -> list[Score]:
    """Return the scores of what one trial would have more than the others, of a model's effects."""
    trials = found.recorded.trials
    there = {(active.effect, active.trial) for active in found.model.effects}
    candidates = [
        (ActiveEffect(active.effect, trial=trial), np.where(active.strengths, 0.0, values))
        for index, active in enumerate(found.model.effects)
        if len(trials) > 1 and active.trial is None and active.effect.has_score and not active.effect.states
        for trial in trials
        if (active.effect, trial) not in there
        for values in [found.values[found.model.places(index)]]
    ]
    return scores(found, candidates) if candidates else []


def _at_instants(found: WholeSwings) -> Iterator[Score]:
    """Yield the scores of what happens at an instant."""
    own = len(found.values)
    for moves, by_joint in zip((True, False), shocks(found), strict=True):
        for joint, shock in by_joint.items():
            of = (e for e in known_effects() if e.at_an_instant and e.joint == joint and e.moves == moves)
            effect = next(of, None)
            if effect is None or (not moves and abs(shock.size) < 0.5 * found.recorded.steps[JOINTS.index(joint)]):
                continue  # what is less is rounding, of a joint that rests
            nothing = np.zeros(own), np.zeros((own, own))
            values = np.array([shock.size, shock.time])
            others = tuple(np.array(other) for other in shock.elsewhere)
            active = ActiveEffect(effect, trial=shock.trial)
            yield Score(active, -shock.gain, shock.gain, values, *nothing, elsewhere=others)


def with_one_more(found: WholeSwings, active: ActiveEffect, values: Array) -> Neighbour:
    """Return a model with an effect more, in the place of the one that it contains, if any, whose values it has too."""
    index = _contained(found.model, active.effect)
    if index is None:
        return Neighbour(found.model.with_effect(active), np.concatenate([found.values, values]), (active.key,), found)
    own = _by_name(found, index)
    more = [value + own.get(p.name, 0.0) for p, value in zip(active.fitted, values.tolist(), strict=True)]
    return _instead(found, index, active, more)


def _instead(found: WholeSwings, index: int, active: ActiveEffect, values: Sequence[float]) -> Neighbour:
    """Return a model with an effect in the place of another one."""
    others, remain = found.model.without_effect(index)
    lower, upper = (np.array([getattr(p, end) for p in active.fitted]) for end in ("lower", "upper"))
    begin = np.concatenate([found.values[remain], np.clip(values, lower, upper)])
    return Neighbour(others.with_effect(active), begin, (active.key,), found)


def _contained(model: MotionModel, effect: Effect) -> int | None:
    """Return which of a model's effects another one contains, if any."""
    for index, active in enumerate(model.effects):
        if effect.extends(active.effect):
            return index
    return None


def _by_name(found: WholeSwings | Neighbour, index: int) -> dict[str, float]:
    """Return the values of an effect's parameters, by their names."""
    values = found.values[found.model.places(index)].tolist()
    return dict(zip((p.name for p in found.model.effects[index].fitted), values, strict=True))


def extended_models(found: WholeSwings) -> Iterator[Neighbour]:
    """Yield models that extend an effect and have no score, or too small a one.

    So it is where a torque is missing, or an encoder's noise is autocorrelated: these follow what it has more.
    """
    more = hides_more(found)
    for index, active in enumerate(found.model.effects):
        for form in [] if active.is_difference else _extended([active.effect]):
            for values in islice(beginnings_of(found, _by_name(found, index), form), 1):
                if more or not form.has_score:
                    yield _instead(found, index, replace(active, effect=form), values)


def hides_more(found: WholeSwings) -> bool:
    """Return whether a torque is missing, or an encoder's noise is autocorrelated."""
    return bool(np.any(found.leaves_more | (found.noise.kept > 0.0)))


def beginnings_of(found: WholeSwings, known: Mapping[str, float], effect: Effect) -> Iterator[list[float]]:
    """Yield values to begin a model with an effect with, of whose parameters some may be known.

    One that has no formulas for it is tried with several typical values. Where a formula gives one that can only be
    positive less than nothing, the effect is not there.
    """
    fitted, unit = ActiveEffect(effect).fitted, found.recorded.time_unit
    usual = {parameter.name: typical(parameter, unit) for parameter in fitted}
    coefficients = found.model.coefficients(found.values).tolist()
    given = {**dict(zip(COEFFICIENTS, coefficients, strict=True)), **usual, **known}
    given["m2_l2"] = given["A23"] / given["L"]
    formulas = max(len(parameter.begins) for parameter in fitted)
    for k in range(formulas or len(SHAPES)):
        factor, values = (1.0 if formulas else SHAPES[k]), dict[str, float]()
        for parameter in fitted:
            if parameter.name in known:
                value = known[parameter.name]
            elif parameter.begins:
                value = evaluated(parameter.begins[k], given | values)
            else:
                value, factor = factor * usual[parameter.name], 1.0
            values[parameter.name] = value
        if all(values[parameter.name] > 0.0 or parameter.lower <= 0.0 for parameter in fitted):
            yield list(values.values())


def replacements(
    found: WholeSwings, index: int, without: WholeSwings, scored: Sequence[Score], beside: Sequence[Score]
) -> Iterator[Neighbour]:
    """Yield models in which another effect takes the place of one, the most promising first.

    It takes the place as far as it does more for the model without that effect than beside it.

    Args:
        found: a model.
        index: of the effect.
        without: the model without it.
        scored: what effects that last and have a name would do for that one, see `scores_of`.
        beside: what effects would do for the model itself.
    """
    own = found.model.effects[index].effect
    of_own = min((score.misfit for score in scored if score.active.effect == own), default=0.0)
    with_own = {score.active.key: min(score.misfit, 0.0) for score in beside}
    for score in scored:
        effect = score.active.effect
        in_its_place = score.misfit - with_own.get(score.active.key, 0.0)
        if effect != own and in_its_place < min(_ALTERNATIVES * of_own, _PROMISES):
            yield with_one_more(without, score.active, score.values)
            # The motion is known with the effect: what moves the rods alike may be at a better maximum from there.
            no_strength = np.where(score.active.strengths, 0.0, score.values)
            yield replace(_instead(found, index, score.active, no_strength.tolist()), again=True)


def near_a_place(without: WholeSwings, effect: Effect) -> Iterator[Neighbour]:
    """Yield models in which what acts near a place takes that of another form of the same effect.

    Args:
        without: the model without that.
        effect: that form.
    """
    others = [e for e in known_effects() if e.is_local and (e.name, e.joint) == (effect.name, effect.joint)]
    for score in scores(without, begun([e for e in others if e != effect], without.recorded.time_unit))[:PLACES]:
        yield replace(with_one_more(without, score.active, score.values), again=True)


def beside_rivals(found: WholeSwings, before: WholeSwings, rivals: Sequence[WholeSwings]) -> Iterator[Neighbour]:
    """Yield models in which what was added last is beside the best rival of each effect that was there before.

    Which of two effects is the more probable one may be another, once what they both lack is there.

    Args:
        found: a model.
        before: the one that it was, with one effect less.
        rivals: other models, the most probable first.
    """
    *_, added = found.model.effects
    values = found.values[found.model.places(len(found.model.effects) - 1)]
    for active in before.model.effects:
        others = Counter(before.model.effects) - Counter([active])
        for rival in rivals:
            instead = [*(Counter(rival.model.effects) - others)]
            if len(rival.model.effects) == len(before.model.effects) and len(instead) == 1 and instead != [active]:
                if not _in_the_way(added.effect, instead[0].effect):
                    yield replace(with_one_more(rival, added, values), what=(instead[0].key,))
                break


def together(one: WholeSwings, other: WholeSwings) -> Iterator[Neighbour]:
    """Yield the model with the effects of two others that are in different joints: in one, either is for the other.

    It begins with the motion of each.
    """
    joints = [{active.effect.joint for active in found.model.effects} for found in (one, other)]
    for first, second in ((one, other), (other, one)) if joints[0].isdisjoint(joints[1]) else ():
        model, values = first.model, first.values
        for index, active in enumerate(second.model.effects):
            model = model.with_effect(active)
            values = np.concatenate([values, second.values[second.model.places(index)]])
        what = tuple(active.key for active in (*one.model.effects, *other.model.effects))
        yield Neighbour(model, values, what, first, again=True)


def extended_replacements(found: WholeSwings, replacement: Neighbour, without: WholeSwings) -> Iterator[Neighbour]:
    """Yield models with extended forms of what takes an effect's place, where more may be hidden.

    Args:
        found: a model.
        replacement: see `replacements`.
        without: the model without the effect.
    """
    last = len(replacement.model.effects) - 1
    active, known = replacement.model.effects[last], _by_name(replacement, last)
    for form in _extended([active.effect]) if hides_more(found) and not active.is_difference else []:
        for values in islice(beginnings_of(without, known, form), 1):
            yield with_one_more(without, replace(active, effect=form), np.array(values))


def at_the_place_of(found: WholeSwings, index: int) -> Iterator[Neighbour]:
    """Yield models in which what acts at a place takes that of an impulse: its joint may have been there once.

    It begins where the joint was shortly before, and is as strong as makes the impulse on the way from there.

    Args:
        found: a model.
        index: of the effect; there are none unless it is an impulse.
    """
    active = found.model.effects[index]
    if not (active.effect.at_an_instant and active.effect.moves):
        return
    joint, (impulse, instant, *duration) = active.effect.joint, found.values[found.model.places(index)].tolist()
    lasts = duration[0] if duration else _SHORT * found.recorded.time_unit
    for swing, states in zip(found.recorded.swings, found.states, strict=True):
        nodes = swing.begin + swing.node_times
        if swing.trial != active.trial or not nodes[0] <= instant <= nodes[-1]:
            continue
        angles, speeds = (
            np.diff(of, axis=1, prepend=zero)[:, JOINTS.index(joint)]
            for of, zero in ((states[:, :2], np.pi), (states[:, 2:RODS_STATES], 0.0))
        )
        for effect in (e for e in known_effects() if e.at_place_of_joint and e.joint == joint):
            fitted = ActiveEffect(effect).fitted
            usual = next(beginnings(ActiveEffect(effect), found.recorded.time_unit))
            strength = next(k for k, parameter in enumerate(fitted) if not parameter.shape)
            place = next(k for k, parameter in enumerate(fitted) if parameter.shape and parameter.begins)
            for ahead in _AHEAD * lasts:
                values = usual.copy()
                values[place], end = between(nodes, angles, speeds, np.array([instant - ahead, instant]))
                values[strength] = abs(impulse) / max(ahead * abs(end - values[place]), 1e-9)
                values[place] = math.remainder(values[place], 2.0 * math.pi)
                yield replace(_instead(found, index, ActiveEffect(effect), values.tolist()), again=True)


def simplifications(found: WholeSwings, sure: float) -> Iterator[Neighbour]:
    """Yield models with one effect less, or with less of one, as far as the strength of that is not sure.

    Of an effect there is less where one of the same kind has some of its parameters alone: a spring without stiffness
    is a constant torque.

    Args:
        found: a model.
        sure: square of a strength in its standard deviations (Wald's statistic) from which on it is.
    """
    for index in range(len(found.model.effects)):
        # Where more is hidden, what is sure may stand for something else.
        if hides_more(found) or strength(found.model, found.values, found.covariance, index) < sure:
            yield without_effect(found, index)
        yield from _less_of(found, index, sure)


def without_effect(found: WholeSwings, index: int) -> Neighbour:
    """Return a model without one of its effects."""
    others, remain = found.model.without_effect(index)
    # What happens at an instant, or near a place, may have been fitted at another one before.
    again = any(other.effect.at_an_instant or other.effect.is_local for other in others.effects)
    return Neighbour(others, found.values[remain], (found.model.effects[index].key,), found, again)


def _less_of(found: WholeSwings, index: int, sure: float) -> Iterator[Neighbour]:
    """Yield models in which an effect has lost some of its parameters, none of which is sure."""
    active, own = found.model.effects[index], _by_name(found, index)
    variances = dict(zip(own, np.diag(found.covariance)[found.model.places(index)], strict=True))
    unsure = {name for name, value in own.items() if value**2 <= sure * variances[name]}
    for effect in known_effects():
        names = {parameter.name for parameter in ActiveEffect(effect).fitted}
        kind = active.effect.joint, active.effect.law.formulas.keys(), active.effect.remembers
        is_alike = kind == (effect.joint, effect.law.formulas.keys(), effect.remembers)
        if is_alike and names < own.keys() and own.keys() - names <= unsure:
            less = replace(active, effect=effect)
            values = [own[parameter.name] for parameter in less.fitted]
            others, remain = found.model.without_effect(index)
            keys = [other.key for other in others.effects]
            if less.key in keys:  # it is there already: both become one
                begin = found.values[remain]
                begin[others.places(keys.index(less.key))] += np.where(less.strengths, values, 0.0)
                neighbour = Neighbour(others, begin, (), found)
            else:
                neighbour = _instead(found, index, less, values)
            # From here it may be far more likely than where it was fitted before: joints stick elsewhere.
            yield replace(neighbour, what=(f"{active.key} but for {effect.key}",), again=True)


def strength(model: MotionModel, values: Array, covariance: Array, index: int) -> float:
    """Return Wald's statistic of an effect's strengths, its shape parameters held where they are known."""
    place = model.places(index)
    of_effect = covariance[place, place]
    known = np.isfinite(np.diag(of_effect))
    strong = model.effects[index].strengths & known
    if not np.any(strong):
        return 0.0
    information = information_of(of_effect[np.ix_(known, known)])
    strengths = np.where(strong, values[place], 0.0)[known]
    return float(strengths @ information @ strengths)


def _states_of(origin: WholeSwings, model: MotionModel) -> list[Array]:
    """Return states to begin with, of a model beside a fitted one; those that other effects bring are zero."""
    before = origin.model
    if [a.effect for a in before.effects if a.effect.states] == [a.effect for a in model.effects if a.effect.states]:
        return list(origin.states)
    own = before.states - RODS_STATES
    states = []
    for of in origin.states:
        brought = np.zeros((len(of), model.states - RODS_STATES))
        at, places = RODS_STATES, dict[str, slice]()
        for active in before.effects:
            places[active.effect.key] = slice(at, at + active.effect.states)
            at += active.effect.states
        begin = 0
        for active in model.effects:
            if active.effect.states and active.effect.key in places:
                brought[:, begin : begin + active.effect.states] = of[:, places[active.effect.key]]
            begin += active.effect.states
        states.append(np.concatenate([of[:, :RODS_STATES], brought, of[:, RODS_STATES + own :]], axis=1))
    return states
