# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The search for the most probable model: from each, its neighbours by one effect, until none is more probable.

Models are compared by one number, their evidence with the odds against their effects (Kass and Raftery, Bayes
factors, J. Am. Stat. Assoc. 90, 1995). In it there is what would have to be rules otherwise: an effect that another
one imitates, or that only noise asks for, makes no model more probable, and where torques are missing that no law
gives, all evidence shrinks by itself. What is imitated there, errors over windows tell (`over_windows`).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import (
    CLOSE_ENOUGH,
    ENOUGH_STEPS,
    best_of,
    likelier_maximum,
    with_less_torque,
)
from cdp_ident.likelihood.scores import Score
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.tracing.neighbours import (
    FEW,
    Neighbour,
    additions,
    at_the_place_of,
    beside_rivals,
    extended_models,
    extended_replacements,
    first,
    hides_more,
    lasts,
    near_a_place,
    replacements,
    scores_of,
    simplifications,
    together,
    without_effect,
)
from cdp_ident.tracing.odds import NOT_DISTINGUISHED, cost, cost_unless_imitated, imitated, size_of, unlikelihood_of
from cdp_ident.tracing.over_windows import OverWindows
from cdp_ident.tracing.selection import Step, Tried
from cdp_ident.tracing.shaped_like import shaped_like_the_last

Key = tuple[tuple[str, int | None, float], ...]
_Fitted = tuple[WholeSwings, tuple[str, ...]]
"""A fitted model, and the keys of the effects that it has more or less."""

_MOST_EFFECTS = 10
SEVERAL = 3
"""So many effects that have a name may explain what a torque without one does."""


class InterruptedSearchError(Exception):
    """The search is asked to stop."""


class ModelSearch:
    """All models that were fitted, and the best of them."""

    def __init__(
        self,
        paper: WholeSwings,
        named_only: bool,
        errors: OverWindows | None = None,
        say: Callable[[str], None] = lambda line: None,
        stop: Callable[[], bool] = lambda: False,
        trying: Callable[[str], None] = lambda line: None,
        begin: WholeSwings | None = None,
    ) -> None:
        """Begin with the paper's model.

        Args:
            paper: the paper's model, fitted.
            named_only: whether nonparametric torques are left out.
            errors: what models leave over windows; without it evidence alone decides.
            say: called with a line of text after each step.
            stop: asked repeatedly; true ends the search.
            trying: called with what is tried next.
            begin: the best model until now, if that is another one.
        """
        self._errors = errors or OverWindows((), paper.recorded.encoders)
        self._recorded, self._say, self._stop, self._trying = paper.recorded, say, stop, trying
        self._named_only = named_only
        self.fitted: dict[Key, WholeSwings] = {_key(found.model): found for found in (paper, begin) if found}
        """All models, by their effects."""
        self._to_beat: dict[Key, float] = {}
        """Misfits that the fits of these were to beat: some were given up."""
        self.steps: list[Step] = []
        self.failures: list[str] = []
        self._scores: dict[int, tuple[WholeSwings, list[Score]]] = {}
        self.paper, self.best = paper, begin or paper
        self._were_best = set[Key]()

    def cost(self, found: WholeSwings) -> float:
        """Return twice the logarithm of how much less probable a model is than the best one until now."""
        return cost(found, self.best)

    def begin_with(self, neighbours: Iterable[Neighbour], action: str) -> None:
        """Try models that are expected, and go on from the most probable one.

        Raises:
            InterruptedSearchError: the search is asked to stop.
        """
        self._move([*neighbours], action)
        self._simplify()

    def run(self, suggested: Sequence[Neighbour] = ()) -> None:
        """Go on until no neighbour is more probable.

        Args:
            suggested: by something else than scores, to be tried at the first step where scored ones leave more than
                noise.

        Raises:
            InterruptedSearchError: the search is asked to stop.
        """
        elsewhere = self._zeros, self._replace, self._look_ahead
        while True:
            neighbours = first(e for e in additions(self.best, self.scores) if len(e.model.effects) <= _MOST_EFFECTS)
            extended = [*extended_models(self.best)]
            # No score tells which of these is more promising than the additions: they compete at once.
            at_once = [form for form in extended if not form.model.effects[-1].effect.has_score]
            extended += [form for each in neighbours for form in extended_replacements(self.best, each, self.best)]
            before, hidden = self.best, [*suggested, *extended]
            moved = self._move(neighbours, "added", hidden, at_once)
            if suggested and hides_more(self.best):
                moved = self._combine(suggested) or moved
            suggested = ()
            if moved:
                if self.best.model.effects[-1].effect.curve is not None:
                    self._spell_out(before)
                self._exchange_for_rivals(before)
                self._simplify()
            elif any(leads() for leads in elsewhere):
                self._simplify()
            else:
                return

    @property
    def scores(self) -> list[Score]:
        """What each effect that the best model does not have would do for it."""
        return self._scores_of(self.best)

    def _scores_of(self, found: WholeSwings) -> list[Score]:
        """Return what each effect would do for a model; it is computed once."""
        if id(found) not in self._scores:
            self._scores[id(found)] = found, scores_of(found, self._named_only)
        return self._scores[id(found)][1]

    def _lasting(self, found: WholeSwings) -> list[Score]:
        """Return the same of effects that last and have a name."""
        if id(found) in self._scores:
            known = self._scores_of(found)
            return [score for score in known if lasts(score.active) and score.active.effect.curve is None]
        return scores_of(found, named_only=True, lasting=True)

    def without(self, index: int) -> WholeSwings | None:
        """Return the best model without one of its effects; None where it cannot be fitted."""
        fitted = self._fit_all([replace(without_effect(self.best, index), again=False)])
        return fitted[0][0] if fitted else None

    def _move(
        self,
        neighbours: Sequence[Neighbour],
        action: str,
        hidden: Sequence[Neighbour] = (),
        at_once: Sequence[Neighbour] = (),
    ) -> bool:
        """Fit neighbours, and go on from the most probable model; return whether that is another one.

        Args:
            neighbours: to be fitted.
            action: in words.
            hidden: others for which no score speaks, or too little, to be fitted where these leave more than noise.
            at_once: others to be fitted in any case.
        """
        tried, best = list[_Fitted](), self.best
        leading = [*at_once, *(each for each in neighbours if each.what == neighbours[0].what)]
        others = [each for each in neighbours if each.what != neighbours[0].what]
        for some in (leading, others, hidden):
            # What leaves nothing but noise need not compete yet: others are tried in its place later on.
            if not hides_more(best) and (self.cost(best) < 0.0 or some is hidden):
                break
            tried += self._fit_all(some, min(best.misfit, self.best.misfit))
            best, _ = self._most_probable(tried)
        probable = self._probable(tried)
        if not probable:
            tried = self._at_likelier_maxima(tried)
            probable = self._probable(tried)
        if probable:
            best, what = probable[0]
            for other, with_what in probable[1:]:
                if _is_no_larger(other.model, best.model) and self._errors.leaves_less(other, best):
                    best, what = other, with_what
            self._note(f"{action} {' and '.join(what)}", best, tried)
            return True
        if tried:
            self._note("nothing more helps", None, tried)
        return False

    def _at_likelier_maxima(self, tried: Sequence[_Fitted]) -> list[_Fitted]:
        """Return models at their likeliest maxima, those with more effects: torques or noise may follow these, too."""
        more = [size_of(of.model) > size_of(self.best.model) and hides_more(of) for of, _ in tried]
        # Of the others the leading ones were, as they were fitted.
        unlikely = [it and cost_unless_imitated(of, self.best) >= 0.0 for it, (of, _) in zip(more, tried, strict=True)]
        fits = parallel_map(lambda k: likelier_maximum(tried[k][0]) if unlikely[k] else tried[k][0], range(len(tried)))
        return [(self._keep(found), what) for found, (_, what) in zip(fits, tried, strict=True)]

    def _probable(self, tried: Sequence[_Fitted]) -> list[_Fitted]:
        """Return the models that are more probable than the best one and explain the motion, the most probable first.

        Fits are no more exact than asked here, and back to a model that is not distinguished leads nowhere.
        """
        better = [
            (found, what)
            for found, what in tried
            if self.cost(found) < -(NOT_DISTINGUISHED if _key(found.model) in self._were_best else CLOSE_ENOUGH)
        ]
        explaining = [pair for pair in better if self._errors.explains(pair[0], self.best)]
        return sorted(explaining, key=lambda pair: self.cost(pair[0]))

    def _keep(self, found: WholeSwings) -> WholeSwings:
        """Return a model as it is the most likely one until now, and keep it so."""
        key = _key(found.model)
        if key not in self.fitted or found.misfit < self.fitted[key].misfit:
            self.fitted[key] = found
        return self.fitted[key]

    def _most_probable(self, tried: Sequence[_Fitted]) -> _Fitted:
        """Return the most probable of some models; the best one until now where there is none."""
        return min(tried, key=lambda pair: self.cost(pair[0]), default=(self.best, ()))

    def _note(self, action: str, best: WholeSwings | None, tried: Sequence[_Fitted]) -> None:
        """Go on from another model, if there is one, and keep what was tried."""
        by_what = {what: self.cost(of) for of, what in tried}
        said = sorted((Tried(what, misfit) for what, misfit in by_what.items()), key=lambda one: one.misfit)
        gained = -0.5 * self.cost(best or self.best) / math.log(10.0)
        self._were_best.add(_key(self.best.model))
        self.best = best or self.best
        self.steps.append(Step(action, -self.cost(self.paper), tuple(said)))
        if best:
            self._say(f"{action}: the model is 10^{gained:.0f} times as probable")

    def _simplify(self) -> None:
        """Drop effects without which the model is the more probable one."""
        while self.best.model.effects:
            neighbours = [*simplifications(self.best, _SURE + imitated(self.best))]
            if not neighbours:
                return
            tried = self._fit_all(neighbours)
            simpler, what = self._most_probable(tried)
            if not tried or self.cost(simpler) > 0.0 or not self._errors.explains(simpler, self.best):
                return
            self._note(f"dropped {' and '.join(what)}", simpler, tried)

    def _with_less_torque(self, found: WholeSwings) -> WholeSwings:
        """Return a model with less unknown torque, if any is missing: else it follows what scores are to tell."""
        try:
            return with_less_torque(found) if np.any(found.is_missing) else found
        except (IdentificationError, np.linalg.LinAlgError) as error:
            self.failures.append(f"less unknown torque: {error}")
            return found

    def _zeros(self) -> bool:
        """Try encoders whose zeros differ from trial to trial."""
        trials, model = self._recorded.trials, self.best.model
        shows = any(active.effect.is_of_a_zero for active in model.effects) or bool(np.any(self.best.leaves_more))
        if len(trials) < 2 or model.zeros or not shows:
            return False
        others, values = model, self.best.values
        for index in reversed(range(len(model.effects))):
            if model.effects[index].effect.is_of_a_zero:
                others, remain = others.without_effect(index)
                values = values[remain]
        neighbours = []
        # Beside effects that are like zeros, and in their place.
        for joints in ((JOINTS[0],), (JOINTS[1],), JOINTS):
            for of, begin in {model: self.best.values, others: values}.items():
                begins = replace(of, zero_joints=joints).with_zeros(begin, trials)
                neighbours.append(Neighbour(*begins, (f"{' and '.join(joints)} zeros of each trial",), self.best))
        return self._move(neighbours, "added")

    def _spell_out(self, before: WholeSwings) -> None:
        """Try named effects in the place of a nonparametric torque, and extended models of those that are."""
        alike, base = list[Neighbour](), self.best.values[: len(before.values)]
        try:
            for active, values in shaped_like_the_last(self.best):
                begins = np.concatenate([base, values])
                alike.append(Neighbour(before.model.with_effect(active), begins, (active.key,), before, again=True))
        except (np.linalg.LinAlgError, ValueError) as error:
            self.failures.append(f"effects like {self.best.model.effects[-1].key}: {error}")
        tried = [*self._grown(before, named_only=True, alike=alike)]
        named, added = min(tried, key=lambda pair: self.cost(pair[0]), default=(before, ()))
        if self.cost(named) < 0.0 and self._errors.explains(named, self.best):
            self._note(f"exchanged for {' and '.join(added)}", named, tried)

    def _combine(self, suggested: Sequence[Neighbour]) -> bool:
        """Try two of the suggestions at once: each may promise little while what the other one brings is missing."""
        keys = dict.fromkeys(_key(each.model) for each in suggested)
        promising = [found for key in keys if (found := self.fitted.get(key)) and cost(found, self.paper) < 0.0]
        some = sorted(promising, key=self.cost)[:FEW]
        pairs = [pair for one, other in combinations(some, 2) for pair in together(one, other)]
        return self._move(pairs, "exchanged for")

    def _exchange_for_rivals(self, before: WholeSwings) -> None:
        """Try what was added last beside other models than the one that was the best one before, if more is hidden."""
        if hides_more(self.best) and len(self.best.model.effects) > len(before.model.effects):
            rivals = sorted(self.fitted.values(), key=self.cost)
            self._move([*beside_rivals(self.best, before, rivals)], "exchanged for")

    def _look_ahead(self) -> bool:
        """Add more to what is more probable than the best model, but explains nothing over windows.

        Of several effects each may explain little of the motion while the others are missing. Once they are there, each
        has to.
        """
        larger = [found for found in self.fitted.values() if size_of(found.model) > size_of(self.best.model)]
        start, tried = min(larger, key=self.cost, default=self.best), list[_Fitted]()
        promises = start is not self.best and cost_unless_imitated(start, self.best) < 0.0
        for ahead, added in self._grown(start, self._named_only) if promises else ():
            tried.append((ahead, added))
            if self.cost(ahead) < 0.0 and self._errors.explains(ahead, self.best):
                kept = self._with_what_explains(ahead)
                there = [active.effect.key for active in self.best.model.effects]
                new = [active.key for active in kept.model.effects if active.effect.key not in there]
                self._note(f"added {' and '.join(new)}", kept, tried)
                return True
        return False

    def _with_what_explains(self, found: WholeSwings) -> WholeSwings:
        """Return a model without effects that explain nothing over windows beside the others."""
        for neighbour in simplifications(found, np.inf):
            for simpler, _ in self._fit_all([neighbour], np.inf):
                if self.cost(simpler) < 0.0 and not self._errors.explains(found, simpler):
                    return self._with_what_explains(simpler)
        return found

    def _grown(self, found: WholeSwings, named_only: bool, alike: Sequence[Neighbour] = ()) -> Iterator[_Fitted]:
        """Yield the most probable model with one effect more, with two and so on, each of which is more probable so.

        The few most probable ones of each size go on: which of two effects is, may change with what is beside it.

        Args:
            found: the model.
            named_only: whether nonparametric torques are left out.
            alike: neighbours of it besides those that scores propose.
        """
        grown: list[_Fitted] = [(found, ())]
        for _ in range(SEVERAL):
            larger = dict[int, _Fitted]()
            for origin, added in grown:
                scored = [s for s in self._scores_of(origin) if not (named_only and s.active.effect.curve)]
                better = self._better(origin, [*alike, *first(additions(origin, scored))])
                for more, what in better or self._better(origin, [*extended_models(origin)]):
                    larger.setdefault(id(more), (more, (*added, *what)))
            if not larger:
                return
            grown, alike = sorted(larger.values(), key=lambda pair: self.cost(pair[0]))[:FEW], ()
            yield grown[0]

    def _better(self, than: WholeSwings, neighbours: Sequence[Neighbour]) -> list[_Fitted]:
        """Return the neighbours of a model that are more probable, with what they have more."""
        return [(found, what) for found, what in self._fit_all(neighbours, than.misfit) if cost(found, than) < 0.0]

    def _replace(self) -> bool:
        """Try other effects in the place of each one, their extended forms, and an extended model of another one."""
        alternatives = list[Neighbour]()
        for index in range(len(self.best.model.effects)):
            alternatives += at_the_place_of(self.best, index)
            without = self.without(index)
            if without is None:
                continue
            less = self._with_less_torque(without)
            others = first(replacements(self.best, index, less, self._lasting(less), self.scores))
            extended = [form for each in others for form in extended_replacements(self.best, each, without)]
            alternatives += [*others, *extended, *near_a_place(less, self.best.model.effects[index].effect)]
            alternatives += extended_models(without)
        return self._move(alternatives, "exchanged for")

    def _fit_all(self, neighbours: Sequence[Neighbour], to_beat: float | None = None) -> list[_Fitted]:
        """Return fitted neighbours.

        Args:
            neighbours: to be fitted; of one model there may be several, which begin elsewhere.
            to_beat: misfit of a model; by default of the best one.
        """
        if not neighbours:
            return []
        if self._stop():
            raise InterruptedSearchError
        self._trying(", ".join(dict.fromkeys(" and ".join(neighbour.what) for neighbour in neighbours)))
        begun, least = dict[Key, list[Neighbour]](), self.best.misfit if to_beat is None else to_beat
        for each in neighbours:
            key = _key(each.model)
            if each.again or (key not in begun and not self._is_fitted(key, least)):
                begun.setdefault(key, []).append(each)
        fits = [*parallel_map(lambda of: self._near(of, least), [*begun.values()])]
        for (key, of), (found, failures) in zip(begun.items(), fits, strict=True):
            self._to_beat[key] = max(least, self._to_beat.get(key, -np.inf))
            self.failures += [f"{' and '.join(of[0].what)}: {failure}" for failure in failures]
            # What is kept does not depend on which fit is done first.
            if found:
                self._keep(found)
        new = [found for found, _ in fits if found and cost_unless_imitated(found, self.best) < 0.0]
        lowest = min(map(self.cost, new), default=0.0)
        # Torques may follow what they explain: without them they may be far more likely.
        leading = [found for found in new if hides_more(found) and self.cost(found) < lowest + _HOPELESS]
        for found in parallel_map(likelier_maximum, leading):
            self._keep(found)
        by_model = {_key(each.model): each.what for each in reversed(neighbours)}
        return [(self.fitted[key], what) for key, what in by_model.items() if key in self.fitted]

    def _is_fitted(self, key: Key, to_beat: float) -> bool:
        """Return whether a model was fitted to the end, or given up where it had no more to beat than it has now."""
        found = self.fitted.get(key)
        to_the_end = found is not None and (found.converged or found.steps >= ENOUGH_STEPS)
        return to_the_end or (found is not None and to_beat <= self._to_beat.get(key, np.inf))

    def _near(self, begun: Sequence[Neighbour], to_beat: float) -> tuple[WholeSwings | None, list[str]]:
        """Fit a model from where it may begin; see `best_of`.

        Args:
            begun: the model, at these places.
            to_beat: misfit of another model that has as many effects.
        """
        if len(begun[0].model.effects) < len(self.best.model.effects):
            to_beat = np.inf
        searches, promised = list[GaussNewton](), np.inf
        for each in begun:
            noise = each.origin.noise
            if len(each.values) < len(each.origin.values):
                # What is left out may have to be followed by unknown torques from now on.
                noise = noise.with_torque_of_at_least(_AT_LEAST * self._recorded.large_torque)
            search = GaussNewton(each.model, each.values, self._recorded, each.states, noise, CLOSE_ENOUGH)
            if each.unscored:
                more = unlikelihood_of(each.model, self._recorded) - unlikelihood_of(each.origin.model, self._recorded)
                promised = each.origin.misfit - more
            if not each.unscored or search.expected_misfit() < promised + _UNPROMISING:
                searches.append(search)
        return best_of(searches, to_beat + _HOPELESS, promised=promised)


_HOPELESS = 30.0
"""A model whose misfit is larger than the best one's by this is not fitted to the end."""
_UNPROMISING = 100.0
"""What no score speaks for is not fitted from where its first step makes it less probable by this; a few steps have to
make it more probable."""
_SURE = 100.0
"""An effect whose strength has a square larger by this than what is imitated is not tried to be dropped."""
_AT_LEAST = 1e-2
"""Unknown torques to begin with where an effect is left out, over large ones."""


def _is_no_larger(one: MotionModel, other: MotionModel) -> bool:
    """Return whether a model has no more effects than another one, and no more states: those of windows are fitted."""
    return size_of(one) <= size_of(other) and one.states <= other.states


def _key(model: MotionModel) -> Key:
    """Return what a model is known by: its effects, in any order, and whether trials have zeros of their own."""
    effects = sorted((a.effect.key, -1 if a.trial is None else a.trial, a.bend) for a in model.effects)
    return tuple(effects + [(f"zero.{joint}", len(model.zeros), 0.0) for joint in model.zero_joints if model.zeros])
