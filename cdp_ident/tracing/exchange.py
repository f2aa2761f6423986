"""Exchange steps: every effect is compared with its rivals, in the model with all other effects."""

import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from itertools import combinations

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import Effect, exclude_each_other
from cdp_ident.model.formulas import language
from cdp_ident.model.formulas.syntax import evaluated
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import is_accepted, may_be_accepted
from cdp_ident.tracing.candidates import Candidate, ScoreTest, addable
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.noise_memory import is_structured
from cdp_ident.tracing.preference import is_better, is_richer_form, is_simpler, may_be_better
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.screening import promising

Array = npt.NDArray[np.float64]

_RIVALS = 3
"""Number of rivals that each effect is compared with."""
_SECONDS = 3
"""So many effects are tried beside what a richer form contains, in its place."""
_SHAPES = (0.3, 1.0, 4.0)
"""A richer form is fitted from initial values of its shape parameters at so many times the typical ones."""
_ONE_SHAPE = (1.0,)
"""The same for what has a memory, which takes long to compute and converges from far away, and for simpler forms."""
_SOME = 0.3
"""Initial value of an additional strength, as a share of the simpler form's strength."""


def exchange_effects(progress: Progress) -> bool:
    """Compare effects, alone and by two of a joint, with rivals; return whether any was exchanged.

    Two are compared together if both are torques or both errors of the encoder.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    before = progress.current
    left: Sequence[tuple[str, ...]] = [(label,) for label in before.model.labels]
    while left:
        left = _exchange_first(progress, left)
    kinds = [(active.effect.moves, active.effect.joint) for active in progress.current.model.effects]
    of_kinds = zip(progress.current.model.labels, kinds, strict=True)
    left = [(one, two) for (one, kind), (two, other_kind) in combinations(of_kinds, 2) if kind == other_kind]
    while left:
        left = _exchange_first(progress, left)
    return progress.current is not before


def _exchange_first(progress: Progress, together: Sequence[tuple[str, ...]]) -> Sequence[tuple[str, ...]]:
    """Exchange the first effects that have a better rival, and return which ones are left to be compared.

    All are compared at the same time, in the present model; those after an exchange, in the model that it leads to.
    What was compared in the present model before, without an exchange, is not compared again.

    Args:
        progress: of the selection.
        together: labels of effects; those of each tuple are exchanged together.
    """
    current, exchanged = progress.current, threading.Event()
    compared_before = progress.compared_in(current)
    # Others may have been exchanged together with one of their kind.
    present = (labels for labels in together if set(labels) <= set(current.model.labels))
    together = [labels for labels in present if labels not in compared_before]
    without = progress.without_each(current, [[current.place_of(label) for label in labels] for labels in together])

    def compared(place: int) -> tuple[list[Attempt], list[str]]:
        aside = progress.aside(exchanged.is_set)
        return _rivals(aside, without[place], *together[place]), aside.failures

    for place, (rivals, failures) in enumerate(parallel_map(compared, range(len(together)))):
        for line in failures:
            progress.fail(line)
        labels = together[place]
        compared_before.add(labels)
        if len(labels) == 1:
            progress.rivals[labels[0]] = tuple(rivals)
        best = _better(current, without[place], rivals)
        if best is not None:
            exchanged.set()
            _take(progress, best, " and ".join(labels))
            return together[place + 1 :]
    return []


def try_states(progress: Progress, suits: Callable[[Effect], bool]) -> None:
    """Exchange effects for their richer forms with states of their own, of one kind, where those are better.

    What a simpler form leaves (a cart that gives way but does not oscillate, friction that is not elastic before it
    slips) is small and follows the motion: other effects would take it over before all of them stand against their
    rivals.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    _try_richer(progress, lambda effect: effect.brings_states and suits(effect))


def try_without_states(progress: Progress) -> None:
    """Exchange effects for their richer forms without states of their own where those are better.

    A simpler form (dry friction for friction that is larger near rest) may end so far from the motion that nothing can
    be added to it.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    _try_richer(progress, lambda effect: not effect.brings_states)


def try_without_memory(progress: Progress) -> None:
    """Exchange effects that have a memory for what they contain where that explains the motion as well.

    While other effects are missing, friction with a memory may have taken over a part of what they do. It takes long to
    compute, and stands in the way of what is to be added next.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    for active, old in zip(progress.current.model.effects, progress.current.model.labels, strict=True):
        if active.effect.remembers:
            _try_forms(progress, old, _contained(progress, old))


def _try_richer(progress: Progress, suits: Callable[[Effect], bool]) -> None:
    for old in progress.current.model.labels:
        _try_forms(progress, old, [effect for effect in richer_forms(progress, old) if suits(effect)])


def _try_forms(progress: Progress, old: str, forms: Sequence[Effect]) -> None:
    """Exchange an effect for the best of its other forms that are better, if there is one."""
    if forms:
        removed = progress.without(progress.current, [progress.current.place_of(old)])
        best = _better(progress.current, removed, _related(progress, removed, old, forms))
        if best is not None:
            _take(progress, best, old)


def alternatives(
    active: ActiveEffect, current: Attempt, removed: Attempt, rivals: Sequence[Attempt]
) -> tuple[str, ...]:
    """Return the rivals that the data do not distinguish from the effect that they replaced.

    A richer form with more values, which is the effect itself where they are zero, is one of these only if Bayes's
    information criterion prefers it while only noise remains, though it was not better by enough to be exchanged.

    Args:
        active: the effect.
        current: the model with it.
        removed: the model without it.
        rivals: models with another effect in its place.
    """
    named = {(active.effect.name, active.effect.joint) for active in current.model.effects}
    found = []
    for rival in rivals:
        effect = rival.model.effects[-1].effect
        in_two = len(rival.model.effects) > len(current.model.effects)
        if in_two or (effect.name, effect.joint) in named or not is_accepted(removed, rival):
            continue
        if is_richer_form(effect, active.effect) and len(rival.fit.values) > len(current.fit.values):
            close = change(current, rival).bic < 0 and not is_structured(rival.fit)
        else:
            close = change(rival, current).validation < thresholds.INDISTINGUISHABLE
        if close:
            found.append(f"{effect.name} {effect.joint}")
    return tuple(dict.fromkeys(found))


def _rivals(progress: Progress, removed: Attempt, *keys: str) -> list[Attempt]:
    """Return the models that have another effect in the place of some.

    They are those whose score test gains nearly as much, and the other forms of each. What brings states of its own
    is a rival of what is at the same joint only: its initial values in each window imitate a part of anything.
    """
    current = progress.current
    joints = {current.model.effects[current.place_of(key)].effect.joint for key in keys}
    candidates = [c for c in addable(removed.model) if not c.effect.brings_states or c.effect.joint in joints]
    test = ScoreTest(removed.fit, candidates)
    promised = promising(removed, test, _RIVALS + len(keys), keys)
    forms = {key: [*richer_forms(progress, key), *_contained(progress, key)] for key in keys}
    # Those of the same name, too, that a score test in the model without the effect does not show.
    shown = {candidate.active.effect.key for candidate in promised}
    for key in keys:
        forms[key] += [form for form in _of_the_same_name(progress, key) if form.key not in shown]
    # The score test of what oscillates finds its frequency, which the values of the simpler form do not tell.
    besides = {*keys, *(form.key for of_key in forms.values() for form in of_key if not form.brings_states)}
    others = progress.tried(
        removed,
        ((c,) for c in promised if c.active.effect.key not in besides),
        to_beat=current,
        may_win=partial(may_be_accepted, removed),
    )
    related = [rival for key in keys for rival in _related(progress, removed, key, forms[key], set(keys) - {key})]
    in_two = _in_two(progress, removed, keys[0], related) if len(keys) == 1 else []
    return [*(rival for _, rival in others), *related, *in_two]


def _in_two(progress: Progress, removed: Attempt, key: str, rivals: Sequence[Attempt]) -> list[Attempt]:
    """Return models that have two effects in the place of one: what it contains, and another torque of its joint.

    What a richer form gains may be what another effect does, which was still missing when it was taken.

    Args:
        progress: of the selection.
        removed: the model without the effect.
        key: of the effect.
        rivals: models with other forms of it in its place, but for those that leave far more.
    """
    current, known = progress.current, _values_of(progress, key)
    fitted = {rival.model.effects[-1].effect: rival for rival in rivals}
    beside: list[tuple[Attempt, tuple[Candidate, ...]]] = []
    for simpler in _contained(progress, key):
        begun = [_begun(simpler, known)]
        with_simpler = (
            [fitted[simpler]]
            if simpler in fitted
            else progress.replaced(current, [current.place_of(key)], begun, may_win=lambda _: False)
        )
        for attempt in with_simpler:
            candidates = [
                active
                for active in addable(attempt.model, with_states=False)
                if active.effect.moves
                and active.effect.joint == simpler.joint
                and not is_richer_form(active.effect, simpler)
            ]
            ranked = ScoreTest(attempt.fit, candidates).ranked() if candidates else []
            beside += [(attempt, (second,)) for second in ranked[:_SECONDS]]
    joined = progress.tried_on(beside, to_beat=current, may_win=partial(may_be_accepted, removed))
    return [after for _, _, after in joined]


def _related(
    progress: Progress, removed: Attempt, key: str, forms: Sequence[Effect], besides: Collection[str] = ()
) -> list[Attempt]:
    """Return models with other forms of an effect in its place, and that of others, fitted from the effect's values.

    `removed` is the model without them.

    A score test, which starts from the model without the effect, may not find a richer form, or not be defined for it;
    and a simpler form that begins there may end far from what the richer one led to.
    """
    current = progress.current
    index = current.place_of(key)
    active, known = current.model.effects[index], _values_of(progress, key)
    others: list[tuple[ActiveEffect, Array]] = []
    from_afar: list[tuple[ActiveEffect, Array]] = []
    for form in forms:
        if any(parameter.begins for parameter in form.parameters):
            coefficients = current.model.coefficients(current.fit.values)
            from_afar += _by_formulas(form, known, coefficients)
            continue
        is_one = form.remembers or all(p.name in known for p in ActiveEffect(form).fitted)
        others += [_begun(form, known, factor) for factor in (_ONE_SHAPE if is_one or besides else _SHAPES)]
    left_out = [index, *(current.place_of(other) for other in besides)]

    def may_win(rival: Attempt) -> bool:
        # A richer form that is not better is another possibility only if the information criterion prefers it.
        is_richer = is_richer_form(rival.model.effects[-1].effect, active.effect)
        may_matter = not is_richer or may_be_better(rival, current) or change(current, rival).bic < 0
        return may_be_accepted(removed, rival) and may_matter

    if besides:
        others, from_afar = [], [*from_afar, *others]
    return [
        rival
        for begun, afar in ((others, False), (from_afar, True))
        for rival in progress.replaced(current, left_out, begun, to_beat=current, may_win=may_win, from_afar=afar)
    ]


def _by_formulas(form: Effect, known: Mapping[str, float], coefficients: Array) -> list[tuple[ActiveEffect, Array]]:
    """Return another form of an effect, and the values from which it is fitted as its parameters' formulas say."""
    new = ActiveEffect(form)
    given = {**dict(zip(language.COEFFICIENTS, coefficients.tolist(), strict=True)), **known}
    given["m2_l2"] = given["A23"] / given["L"]
    count = max(len(parameter.begins) for parameter in form.parameters)
    begun = [
        [evaluated(p.begins[k], given) if p.begins else known.get(p.name, p.typical) for p in new.fitted]
        for k in range(count)
    ]
    return [(new, np.clip(begin, *_limits(new))) for begin in begun]


def _values_of(progress: Progress, label: str) -> dict[str, float]:
    """Return the values of an effect's parameters in the present model, by their names."""
    model, values = progress.current.model, progress.current.fit.values
    index = progress.current.place_of(label)
    of_effect = zip(model.effects[index].fitted, values[model.places(index)], strict=True)
    return {parameter.name: float(value) for parameter, value in of_effect}


def _begun(form: Effect, known: dict[str, float], shape: float = 1.0) -> tuple[ActiveEffect, Array]:
    """Return another form of an effect, and the values from which it is fitted.

    Args:
        form: which.
        known: values of the effect's parameters, by name: those with the same name keep theirs.
        shape: the others of shape begin at so many times the typical values.
    """
    new = ActiveEffect(form)
    begin = [known.get(p.name, shape * p.typical if p.shape else _SOME * max(known.values())) for p in new.fitted]
    return new, np.clip(begin, *_limits(new))


def richer_forms(progress: Progress, label: str) -> list[Effect]:
    """Return the effects that contain one; what has a memory takes long, and is tried where more than noise remains."""
    effect = progress.current.model.effects[progress.current.place_of(label)].effect
    structured = is_structured(progress.current.fit)
    richer = [form for form in known_effects() if form.moves and is_richer_form(form, effect)]
    return [form for form in richer if structured or not form.remembers]


def _contained(progress: Progress, label: str) -> list[Effect]:
    """Return the effects that one contains."""
    effect = progress.current.model.effects[progress.current.place_of(label)].effect
    return [form for form in known_effects() if form.moves and is_richer_form(effect, form)]


def _of_the_same_name(progress: Progress, label: str) -> list[Effect]:
    """Return the variants of an effect that neither contain it nor are contained: drag by strips, or by rotation alone.

    Those that bring states of their own are left out.
    """
    effect = progress.current.model.effects[progress.current.place_of(label)].effect
    if effect.harmonic or effect.curve or not effect.moves:
        return []
    same = [form for form in known_effects() if form.moves and exclude_each_other(form, effect)]
    contained = {label, *(form.key for form in same if is_richer_form(form, effect) or is_richer_form(effect, form))}
    return [form for form in same if form.key not in contained and not form.brings_states]


def _limits(active: ActiveEffect) -> tuple[list[float], list[float]]:
    return [p.lower for p in active.fitted], [p.upper for p in active.fitted]


def _better(current: Attempt, removed: Attempt, rivals: Sequence[Attempt]) -> Attempt | None:
    """Return the best of the rivals that are better than what they replace, if there is one."""
    better = [rival for rival in rivals if is_better(rival, current) and is_accepted(removed, rival)]
    return min(better, key=lambda rival: change(removed, rival).bic, default=None)


def _take(progress: Progress, rival: Attempt, old: str) -> None:
    best, simpler = progress.finished(rival), is_simpler(rival, progress.current)
    present = progress.current.model.effects
    new = [active.effect.key for active in best.model.effects if active not in present]
    progress.current = best
    how = f"as well as {old}, which contains it" if simpler else f"better than {old}"
    names, explain = " and ".join(new), "explains" if len(new) == 1 else "explain"
    progress.note(f"exchanged {old} for {names}", best, f"{names} {explain} the motion {how}")
