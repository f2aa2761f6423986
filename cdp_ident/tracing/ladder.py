"""The ladder: effects are added one by one, each judged on windows that it was not fitted to.

At each rung all candidates get a first look, the promising ones a full refit; the best is added if it helps, and what
no longer earns its place is dropped. At the end every effect has to stand against the alternatives once more, under
the model that has all the others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.motion_model import ActiveEffect, MotionModel
from cdp_ident.fit.refinement import Fit, fit_initial_states, refine, refine_from_afar
from cdp_ident.fit.windows import Window
from cdp_ident.model.effects.effect import Effect, Joint, TorqueEffect
from cdp_ident.model.effects.friction import UNEVENNESS
from cdp_ident.tracing.acceptance import (
    FIT_GAIN,
    INSTANT_GAIN,
    KNOCK_ALONE,
    WORTH_NAMING,
    WORTH_NAMING_WITH_OTHERS,
    brings_enough,
    earns_its_place,
    fits_of,
    is_uneven,
    share_explained,
    still_helps,
)
from cdp_ident.tracing.candidates import Candidate, FirstLook, addable
from cdp_ident.tracing.evidence import Attempt, Change, change, sluggishness
from cdp_ident.tracing.instants import instants

Array = npt.NDArray[np.float64]

_MOST_EFFECTS = 8
_REFITS = 6
"""Candidates that get a full refit at a rung."""
_STRONGEST, _SECONDS = 2, 3
"""Where no candidate helps alone, so many are joined by so many others each."""
_WELL_ABOVE_NOISE = 1.2
"""The least error, over the noise, at which that is worth its time."""
_NEAR_A_RIVAL = 0.5
"""An effect that gains less than this share of what another one does at first look is no rival of it."""
_RIVALS = 3
"""Effects that each one has to stand against in the end."""
_WORTH_A_LOOK = 16.0
"""Gain at the first look, in variances, below which a candidate is not refitted."""
_SAFE = 10.0
"""Strength above which an effect is not asked again whether it helps."""
_NEAR_THE_BEST = 0.75
"""A candidate that gains this share of what the best one does is preferred if it has fewer parameters."""
_DRY_FRICTION = ("coulomb_friction", "stribeck_friction")
_MOST_ROUNDS = 3
"""How often effects are added after others were exchanged."""
_INDISTINGUISHABLE = 9.0
"""Models whose squared errors differ by less, in variances, are both possible."""


@dataclass(frozen=True)
class Tried:
    """A candidate that was refitted at a rung."""

    effects: tuple[str, ...]
    """Keys of the effect or, where two only help together, the two."""
    rmse_fit: float
    """[rad]"""
    rmse_holdout: float
    """[rad]"""
    change: Change


@dataclass(frozen=True)
class Rung:
    """One step of the ladder."""

    action: str
    """What was done: added, dropped or exchanged, and what."""
    rmse_fit: float
    """Error of the fit after it [rad]."""
    rmse_holdout: float
    """Error over the windows kept out after it [rad]."""
    tried: tuple[Tried, ...]


@dataclass(frozen=True)
class Rubbing:
    """Dry friction that is there over a part of the turn only."""

    joint: Joint
    angle: float
    """Where it is strongest: the joint's angle from hanging [rad]."""


@dataclass(frozen=True)
class Ladder:
    """Where the ladder ended."""

    before: Attempt
    """The paper's model."""
    after: Attempt
    """The model with the effects."""
    rungs: tuple[Rung, ...]
    evidence: tuple[Change, ...]
    """What each effect of `after` is worth: the change from that model without it."""
    holdout_without: tuple[float, ...]
    """Error over the windows kept out without each of them [rad]."""
    also_possible: tuple[tuple[str, ...], ...]
    """Keys of the effects that could stand in each one's place, as far as the data can tell."""
    rubbing: tuple[Rubbing, ...]
    """No known effect, and no longer in the model: what was first taken for dry friction."""
    interrupted: bool


_Tried = tuple[tuple[Candidate, ...], Attempt]
"""What was added, and what came of it."""


class _Interrupted(Exception):  # noqa: N818  it is no error
    pass


def climb(
    fit: Fit,
    holdout: Sequence[Window],
    noise: float,
    told: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
) -> Ladder:
    """Add to a fitted model the effects that it lacks.

    Args:
        fit: the paper's model, fully fitted.
        holdout: the windows that no fit sees.
        noise: root mean square of what the encoders add to both angles [rad].
        told: called with a line for people after each step.
        stop: asked between refits; true ends the climb with the effects found so far.
    """
    climber = _Climber(noise, told, stop)
    before = Attempt(fit, fit_initial_states(fit.model, fit.values, holdout))
    return climber.run(before)


class _Climber:
    def __init__(self, noise: float, told: Callable[[str], None], stop: Callable[[], bool]):
        self._noise, self._told, self._stop = noise, told, stop
        self._rungs: list[Rung] = []
        self._stood: dict[str, tuple[Attempt, ...]] = {}
        """The rivals that each effect has stood against in the end, by its key."""
        self._rubbing: list[Rubbing] = []

    def run(self, before: Attempt) -> Ladder:
        current, interrupted = before, False
        try:
            for _ in range(_MOST_ROUNDS):
                current = self._add_all(current)
                exchanged = self._exchange(current)
                if exchanged is current:
                    break
                current = self._drop(exchanged)
            current = self._drop_knocks(self._drop_uneven(current))
        except _Interrupted:
            interrupted = True
        current, without = self._keep_what_explains(current)
        alternatives = [
            self._alternatives(active, current, removed, self._stood.get(active.effect.key, ()))
            for active, removed in zip(current.model.effects, without, strict=True)
        ]
        return Ladder(
            before=before,
            after=current,
            rungs=tuple(self._rungs),
            evidence=tuple(change(removed, current) for removed in without),
            holdout_without=tuple(removed.holdout.rmse() for removed in without),
            also_possible=tuple(alternatives),
            rubbing=tuple(self._rubbing),
            interrupted=interrupted,
        )

    def _keep_what_explains(self, current: Attempt) -> tuple[Attempt, list[Attempt]]:
        """Drop effects that explain too little beside what remains: they may be a part of that, imitated.

        One that happened once has its window, which is looked at instead.

        Returns:
            The model with the effects that stay, and that model without each of them.
        """
        while True:
            indices = range(len(current.model.effects))
            without = [self._remove(current, [index]) for index in indices]
            explained = {
                index: share_explained(current, without[index], self._noise)
                for index in indices
                if not current.model.effects[index].effect.at_an_instant
            }
            weak = [index for index, share in explained.items() if share < WORTH_NAMING]
            if not weak:
                return current, without
            least = min(weak, key=explained.__getitem__)
            if len(weak) > 1 and explained[least] > WORTH_NAMING_WITH_OTHERS:
                together = share_explained(current, self._remove(current, weak), self._noise)
                if together > WORTH_NAMING:
                    return current, without
            key = current.model.effects[least].effect.key
            current = without[least]
            self._note_drop(key, current, "it explains too little beside what remains")

    def _add_all(self, current: Attempt) -> Attempt:
        while len(current.model.effects) < _MOST_EFFECTS and (better := self._rung(current)) is not None:
            better = self._drop(better)
            if better.squared_error >= current.squared_error:
                break  # what was added made something else superfluous, and no more came of it
            current = better
        return current

    def _rung(self, current: Attempt) -> Attempt | None:
        """Return the model with the best addition, or None where nothing helps."""
        look = FirstLook(current.fit, addable(current.model))
        ranked = self._promising(current, look, _REFITS)
        attempts: list[_Tried] = [((c,), self._add(current, [c])) for c in (*ranked, *self._once(current))]
        best = self._best(current, attempts)
        if best is None:
            pairs = [p for p in look.pairs(_REFITS // 2) if p[2] > 2 * _WORTH_A_LOOK * _expected(current.fit, p[2])]
            together: list[_Tried] = [((one, two), self._add(current, (one, two))) for one, two, _ in pairs]
            together += self._with_seconds(current, attempts)
            attempts += together
            best = self._best(current, together)
        self._note(current, best, attempts)
        return best

    def _once(self, current: Attempt) -> list[Candidate]:
        """Return what may have happened once, as the windows show it and, if otherwise, as short pieces of them do."""
        found: dict[tuple[str, int | None, float], Candidate] = {}
        for fit in (current.fit, current.closely):
            for candidate in [c for c in instants(fit) if c.gain > INSTANT_GAIN * _expected(fit, c.gain)][:2]:
                *_, time = candidate.values
                found.setdefault((candidate.active.effect.key, candidate.active.trial, round(time, 1)), candidate)
        return list(found.values())

    def _with_seconds(self, current: Attempt, attempts: Sequence[_Tried]) -> list[_Tried]:
        """Return what becomes of the effects that explain most of the fit, if each is joined by a second one.

        Where two are missing, one alone also takes on what the other would explain, and is wrong elsewhere.
        """
        if current.fit.rmse() < _WELL_ABOVE_NOISE * self._noise:
            return []
        strong = [
            (attempt.fit.rmse(), first, attempt)
            for (first,), attempt in attempts
            if not (first.active.effect.at_an_instant or attempt.at_limit(len(current.model.effects)))
            and change(current, attempt).fit > FIT_GAIN
        ]
        strong.sort(key=lambda found: found[0])
        return [
            ((first, second), self._add(attempt, [second]))
            for _, first, attempt in strong[:_STRONGEST]
            for second in self._promising(attempt, FirstLook(attempt.fit, addable(attempt.model)), _SECONDS)
        ]

    def _best(self, current: Attempt, attempts: Sequence[_Tried]) -> Attempt | None:
        accepted = [a for _, a in attempts if earns_its_place(current, a)]
        if not accepted:
            return None
        # The simplest of those that come near the best: while other effects are still missing, what an effect with
        # more parameters gains over a simpler one is mostly theirs. The exchange at the end sets it right if not.
        levels = [min(fit.squared_error for fit in of_all) for of_all in zip(*map(fits_of, accepted), strict=True)]

        def error(attempt: Attempt) -> float:
            return sum(fit.squared_error / level for fit, level in zip(fits_of(attempt), levels, strict=True))

        most = max(error(current) - error(a) for a in accepted)
        near = [a for a in accepted if error(current) - error(a) > _NEAR_THE_BEST * most]
        return min(near, key=lambda a: (len(a.fit.values), error(a)))

    def _add(self, current: Attempt, candidates: Sequence[Candidate]) -> Attempt:
        model, values = current.model, current.fit.values
        for candidate in candidates:
            model = model.with_effect(candidate.active)
            values = np.concatenate([values, candidate.values])
        return self._refit(model, values, current)

    def _refit(self, model: MotionModel, values: Array, current: Attempt) -> Attempt:
        if self._stop():
            raise _Interrupted
        fit = refine_from_afar(model, values, current.fit.windows)
        return Attempt(fit, fit_initial_states(model, fit.values, current.holdout.windows))

    def _remove(self, current: Attempt, indices: Sequence[int]) -> Attempt:
        """Return the model without some of its effects, refitted."""
        model, values = current.model, current.fit.values
        for index in sorted(indices, reverse=True):
            model, remain = model.without_effect(index)
            values = values[remain]
        fit = refine(model, values, current.fit.windows)
        return Attempt(fit, fit_initial_states(model, fit.values, current.holdout.windows))

    def _drop(self, current: Attempt) -> Attempt:
        """Drop effects that no longer help now that others are there."""
        for index in reversed(range(len(current.model.effects) - 1)):
            if current.strength(index) > _SAFE:
                continue
            removed = self._remove(current, [index])
            if not still_helps(current, removed):
                key = current.model.effects[index].effect.key
                current = removed
                self._note_drop(key, current, "it no longer helps")
        return current

    def _drop_knocks(self, current: Attempt) -> Attempt:
        """Drop a knock beside which others would explain something too: what happens again and again is no knock."""
        for index in reversed(range(len(current.model.effects))):
            effect = current.model.effects[index].effect
            if not (isinstance(effect, TorqueEffect) and effect.at_an_instant):
                continue
            removed = self._remove(current, [index])
            gain = removed.fit.squared_error - current.fit.squared_error
            if any(gain < KNOCK_ALONE * another.gain for another in instants(current.fit)):
                current = removed
                self._note_drop(effect.key, current, "knocks at other instants would explain something, too")
        return current

    def _drop_uneven(self, current: Attempt) -> Attempt:
        """Drop dry friction that is there over a part of the turn only: something rubs, which is no such effect."""
        for active in current.model.effects:
            effect = active.effect
            if effect.name not in _DRY_FRICTION:
                continue
            index = current.place_of(effect.key)
            variation = next(varied for varied in UNEVENNESS if varied.joint == effect.joint)
            uneven = self._add(current, [Candidate(ActiveEffect(variation), 0.0, np.zeros(2))])
            if is_uneven(current, uneven, index):
                sine, cosine = uneven.fit.values[uneven.model.places(len(uneven.model.effects) - 1)]
                self._rubbing.append(Rubbing(effect.joint, float(np.arctan2(sine, cosine))))
                current = self._remove(current, [index])
                self._note_drop(effect.key, current, "it is there over a part of the turn only")
        return current

    def _exchange(self, current: Attempt) -> Attempt:
        """Let every effect, and every two torques of a joint, stand against their rivals, all others being there."""
        for old in [active.effect.key for active in current.model.effects]:
            removed = self._remove(current, [current.place_of(old)])
            rivals = self._rivals(removed, old)
            self._stood[old] = tuple(rivals)
            current = self._exchanged(current, removed, rivals, old)
        torques = [active.effect for active in current.model.effects if isinstance(active.effect, TorqueEffect)]
        for one, two in combinations(torques, 2):
            present = {active.effect.key for active in current.model.effects}
            if one.joint == two.joint and {one.key, two.key} <= present:
                removed = self._remove(current, [current.place_of(one.key), current.place_of(two.key)])
                rivals = self._rivals(removed, one.key, two.key)
                current = self._exchanged(current, removed, rivals, f"{one.key} and {two.key}")
        return current

    def _exchanged(self, current: Attempt, removed: Attempt, rivals: Sequence[Attempt], old: str) -> Attempt:
        """Return the best of the rivals that are better than what they replace, or the model as it is."""
        better = [rival for rival in rivals if self._is_better(rival, current) and earns_its_place(removed, rival)]
        if not better:
            return current
        best = min(better, key=lambda rival: change(removed, rival).bic)
        new = best.model.effects[-1].effect.key
        self._rungs.append(Rung(f"exchanged {old} for {new}", best.fit.rmse(), best.holdout.rmse(), ()))
        self._told(f"{new} explains the motion better than {old}")
        return best

    @staticmethod
    def _is_better(rival: Attempt, current: Attempt) -> bool:
        gained = change(current, rival)
        fewer = len(rival.model.effects) < len(current.model.effects)
        if len(rival.fit.values) > len(current.fit.values) and not fewer:
            return gained.bic < 0 and brings_enough(current, rival)  # what is richer must earn its parameters
        return gained.bic < 0 and gained.fit + gained.holdout > _INDISTINGUISHABLE and gained.holdout > 0

    def _rivals(self, removed: Attempt, *keys: str) -> list[Attempt]:
        """Return the models that have another effect in the place of some, if at first look it comes near those."""
        look = FirstLook(removed.fit, addable(removed.model))
        promising = self._promising(removed, look, _RIVALS + len(keys), keys)
        return [self._add(removed, [c]) for c in promising if c.active.effect.key not in keys]

    def _promising(self, current: Attempt, look: FirstLook, most: int, rival_of: Sequence[str] = ()) -> list[Candidate]:
        """Return the candidates that deserve a refit, by a look at the windows and one at short pieces of them.

        With `rival_of`, keys of some of them, only those that gain at least half of what any of these does.

        Where the motion is chaotic, the residual of a model that lacks something is no longer linear in what it
        lacks; over short pieces it still is, but small effects drown in noise there.
        """
        nearby = FirstLook(current.closely, look.candidates)
        seen: dict[str, Candidate] = {}
        for ranking, fit in ((look.ranked(), current.fit), (nearby.ranked(), current.closely)):
            least = _NEAR_A_RIVAL * max((c.gain for c in ranking if c.active.effect.key in rival_of), default=0.0)
            worth = [c for c in ranking if c.gain > max(_WORTH_A_LOOK * _expected(fit, c.gain), least)]
            for candidate in worth[:most]:
                seen.setdefault(candidate.active.effect.key, candidate)
        return list(seen.values())

    def _alternatives(
        self, active: ActiveEffect, current: Attempt, removed: Attempt, rivals: Sequence[Attempt]
    ) -> tuple[str, ...]:
        """Return the rivals that the data cannot tell from the effect whose place they took."""
        named = {(active.effect.name, active.effect.joint) for active in current.model.effects}
        found = []
        for rival in rivals:
            effect = rival.model.effects[-1].effect
            if _is_richer_form(effect, active.effect):
                continue
            worse = change(rival, current)
            close = worse.fit + worse.holdout < _INDISTINGUISHABLE
            if close and (effect.name, effect.joint) not in named and earns_its_place(removed, rival):
                found.append(f"{effect.name} {effect.joint}")
        return tuple(dict.fromkeys(found))

    def _note_drop(self, key: str, after: Attempt, reason: str) -> None:
        self._rungs.append(Rung(f"dropped {key}", after.fit.rmse(), after.holdout.rmse(), ()))
        self._told(f"dropped {key}: {reason}")

    def _note(self, current: Attempt, best: Attempt | None, attempts: Sequence[_Tried]) -> None:
        tried = [
            Tried(tuple(c.active.effect.key for c in candidates), a.fit.rmse(), a.holdout.rmse(), change(current, a))
            for candidates, a in attempts
        ]
        tried.sort(key=lambda attempt: attempt.rmse_holdout)
        added = [e.effect.key for e in best.model.effects[len(current.model.effects) :]] if best else []
        after = best or current
        action = f"added {' and '.join(added)}" if best else "nothing more helps"
        self._rungs.append(Rung(action, after.fit.rmse(), after.holdout.rmse(), tuple(tried)))
        self._told(
            f"{action}: {1e3 * current.holdout.rmse():.3g} -> {1e3 * after.holdout.rmse():.3g} mrad on windows kept out"
        )


def _is_richer_form(effect: Effect, other: Effect) -> bool:
    """Return whether an effect is another one of the same joint with more to it, and so can always stand for that."""
    return isinstance(effect, TorqueEffect) and (effect.joint, effect.contains) == (other.joint, other.name)


def _expected(current: Fit, gain: float) -> float:
    """Return the variance that one independent residual would have after a gain [rad^2]."""
    left = max(current.squared_error - gain, 0.05 * current.squared_error)
    # How sluggish the residual is now says little of how it will be once the effect is there, but for small gains.
    small = gain < 0.3 * current.squared_error
    samples = sum(residual.size for residual in current.residuals)
    return left / samples * (sluggishness(current) if small else 1.0)
