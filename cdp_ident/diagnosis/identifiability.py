# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the trials determine, and what they cannot tell apart.

Two questions are kept apart: how well the motion shows the unknowns of the model (their sensitivities answer), and
which physical values share the same unknowns (the base parameters' formulas answer).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.identification import GUESSED, Identification, Inertia
from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.physical import CONFIDENCE, is_determined, logarithmic_derivatives
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, SYMBOLS

_UNOBSERVABLE = 1e-6
"""Singular value, as a share of the largest, below which a combination of unknowns counts as unobservable."""
_RANK_TOLERANCE = 1e-3
"""A relative change of values that changes the base parameters by less than this share of it counts as changing
nothing."""
_ROD_BY_ROD = ("m1", "J1", "l1", "m0", "m2", "l2", "J2", "c1", "c2")
_BY_EASE_OF_MEASURING = ("m1", "m2", "m0", "l1", "l2", "J1", "J2", "c1", "c2")
_SCALED_TOGETHER = ("m1", "m2", "m0", "J1", "J2", "c1", "c2")


@dataclass(frozen=True)
class Direction:
    """One combination of the model's unknowns, a product of powers of them."""

    singular_value: float
    """Square root of the information on the logarithm of the combination: its inverse is the combination's relative
    standard deviation."""
    exponents: Mapping[str, float]
    """Power of each unknown in the combination; their squares add up to 1."""


class Tradeoff(dict[str, float]):
    """Values that can change together without any change of the motion: the relative change of each, at most 1."""

    @classmethod
    def of(cls, names: Sequence[str], vector: Array) -> "Tradeoff":
        """Make one of values' names and a vector (names,) of relative changes, of which some may be zero."""
        vector = vector / _largest(vector)
        return cls({name: float(v) for name, v in zip(names, vector, strict=True) if abs(v) > _RANK_TOLERANCE})

    def __str__(self) -> str:
        names = list(self)
        if len({round(change, 6) for change in self.values()}) == 1:
            return f"{_enumerated(names)} can all be multiplied by one factor without changing the motion"
        example = ", ".join(f"{name} {change:+.2g} %" for name, change in self.items())
        return f"{_enumerated(names)} cannot be told apart: {example} together change nothing"


@dataclass(frozen=True)
class Identifiability:
    """What the trials determine."""

    directions: tuple[Direction, ...]
    """Combinations of the unknowns, the best determined first."""
    undetermined: tuple[str, ...]
    """Unknowns whose 95 % interval is wider than half their value to either side."""
    unseen_changes: tuple[Tradeoff, ...]
    """Unobservable combinations: unknowns that can change together without changing the motion."""
    determined_physical: tuple[str, ...]
    """Physical values that the trials determine, with what was measured beforehand."""
    physical_changes_without_effect: tuple[Tradeoff, ...]
    """Physical values that can change together without changing the base parameters."""
    to_measure: tuple[str, ...]
    """Physical values which, measured as well, would make all others determinable."""
    words: tuple[str, ...]
    """The same in sentences for people."""


def identifiability(found: Identification) -> Identifiability:
    """Say what an identification determines."""
    fit, covariance, physical, inertia = found.fit, found.covariance, found.physical, found.inertia
    prior = found.options.prior
    length, _ = fit.model.constants(fit.values)
    named = np.flatnonzero(fit.model.of_rig & ~fit.model.of_curves)
    names, values = [fit.model.names[index] for index in named], fit.values[named]
    std = np.sqrt(np.diag(covariance))[named]
    undetermined = tuple(
        name for name, value, deviation in zip(names, values, std, strict=True) if not is_determined(value, deviation)
    )
    directions, unobservable = _directions(fit, found.whole.triangle)
    # A base parameter that is correlated with L or g is determined as well as they are known.
    hidden = set(undetermined) - {name for tradeoff in unobservable for name in tradeoff}
    shown = (*GROUPS, INVERSE_INERTIA) if inertia.shown else GROUPS
    seen = [index for index, group in enumerate(shown) if group.symbol not in hidden]
    derivatives = logarithmic_derivatives(physical.values, length, inertia.shown)[seen]
    # A value of zero has no relative change; what is known does not change; an impossible mechanism says nothing; and a
    # friction whose base parameter is not determined stands alone.
    free = [
        symbol
        for symbol in _ROD_BY_ROD
        if physical.possible
        and symbol not in prior.known
        and physical.values[SYMBOLS.index(symbol)] > 0
        and np.any(np.abs(derivatives[:, SYMBOLS.index(symbol)]) > _RANK_TOLERANCE)
    ]
    columns = derivatives[:, [SYMBOLS.index(symbol) for symbol in free]]
    result = Identifiability(
        directions=directions,
        undetermined=undetermined,
        unseen_changes=unobservable,
        determined_physical=tuple(s for s, sure in zip(SYMBOLS, physical.determined, strict=True) if sure),
        physical_changes_without_effect=tuple(_tradeoffs(free, columns)),
        to_measure=_to_measure(free, columns),
        words=(),
    )
    words = [*_words_on_unknowns(result, names, values, std), *_words_on_inertia(fit, inertia, found.data.names)]
    if physical.possible:
        words += _words_on_physical_values(result, tuple(prior.known), inertia, physical.inertia_std_once_weighed)
    return replace(result, words=tuple(words))


def _directions(fit: Fit, triangle: Array) -> tuple[tuple[Direction, ...], tuple[Tradeoff, ...]]:
    """Part the unknowns that are not zero into combinations, by the singular values of their scaled information."""
    shown = np.flatnonzero(fit.model.of_rig & ~fit.model.of_curves & (fit.values != 0.0))
    names = [fit.model.names[index] for index in shown]
    scaled = triangle[:, shown] * fit.values[shown]
    _, singular, vectors = np.linalg.svd(scaled, full_matrices=False)
    vectors = np.array([vector * np.sign(_largest(vector)) for vector in vectors])
    directions = tuple(
        Direction(float(value), dict(zip(names, vector.tolist(), strict=True)))
        for value, vector in zip(singular, vectors, strict=True)
    )
    return directions, tuple(Tradeoff.of(names, vector) for vector in vectors[singular <= _UNOBSERVABLE * singular[0]])


def _largest(vector: Array) -> float:
    """Return the largest component of a vector, the first of those that are so by rounding alone."""
    sizes = np.abs(vector)
    return float(vector[np.argmax(sizes > (1.0 - _RANK_TOLERANCE) * sizes.max())])


def _tradeoffs(names: Sequence[str], columns: Array) -> Iterator[Tradeoff]:
    """Yield independent relative changes of few values each that leave the base parameters as they are.

    `columns` (base parameters, names) have the logarithmic derivatives of these by the values.
    """
    found: Array = np.zeros((0, len(names)))
    together = tuple(names.index(name) for name in _SCALED_TOGETHER if name in names)
    smallest_first = (chosen for size in range(2, len(names) + 1) for chosen in combinations(range(len(names)), size))
    for chosen in chain([together] if together else [], smallest_first):
        if len(found) == len(names) - _rank(columns):
            return
        part = columns[:, chosen]
        vector = np.full(len(chosen), len(chosen) ** -0.5) if chosen is together else np.linalg.svd(part)[2][-1]
        if np.linalg.norm(part @ vector) > _RANK_TOLERANCE:
            continue
        whole = np.zeros((1, len(names)))
        whole[0, chosen] = vector
        if _rank(more := np.concatenate([found, whole])) > len(found):
            found = more
            yield Tradeoff.of([names[k] for k in chosen], vector)


def _to_measure(names: Sequence[str], columns: Array) -> tuple[str, ...]:
    """Return values, the easiest to measure first, that leave nothing undetermined once they are known."""

    def freedom(left: Sequence[str]) -> int:
        return len(left) - _rank(columns[:, [names.index(name) for name in left]])

    left, chosen = list(names), list[str]()
    for name in _BY_EASE_OF_MEASURING:
        without = [other for other in left if other != name]
        if freedom(without) < freedom(left):
            left = without
            chosen.append(name)
    return tuple(chosen)


def _rank(matrix: Array) -> int:
    return int(np.linalg.matrix_rank(matrix, tol=_RANK_TOLERANCE)) if matrix.size else 0


def _words_on_unknowns(found: Identifiability, names: Sequence[str], values: Array, std: Array) -> Iterator[str]:
    formulas = {group.symbol: group.formula for group in (*GROUPS, INVERSE_INERTIA)}
    shares = {name: CONFIDENCE * s / abs(v) for name, v, s in zip(names, values, std, strict=True) if v}
    clear = [name for name in names if name not in found.undetermined]
    if clear:
        shown = [f"{formulas.get(name, name)} (±{100 * shares[name]:.2g} %)" for name in clear]
        yield f"these trials see {_enumerated(shown)}, with A22 = m1 l1^2 + J1 + (m2 + m0) L^2"
    for name in found.undetermined:
        shown_share = f" (±{100 * shares[name]:.2g} %)" if np.isfinite(shares.get(name, np.inf)) else ""
        yield f"{formulas.get(name, name)} is not determined by these trials{shown_share}"
    yield from map(str, found.unseen_changes)
    if INVERSE_INERTIA.symbol in names:
        return  # a weight's place is a length beside L
    if "L" in names and "g" not in names:
        yield "L is fitted on the strength of g: an error of g makes the same relative error of L"
    if "g" in names and "L" not in names:
        yield "g is fitted on the strength of L: an error of L makes the same relative error of g"


def _words_on_inertia(fit: Fit, inertia: Inertia, trials: Sequence[str]) -> Iterator[str]:
    """Say what A22 is and what shows it, if anything: weights or motors."""
    if not fit.model.inertia_free:
        return
    weighted = [trials[index] for index in sorted({window.trial for window in fit.windows if window.weights})]
    by, more = (
        f"by the {'weight' if len(weighted) == 1 else 'weights'} in {_enumerated(weighted)}",
        "a heavier one, or one further out",
    )
    if fit.model.motors:
        by, more = f"by the motors' torques, known to {100.0 * fit.model.torque_std:.2g} %", "stronger ones"
        imbalance, *late = fit.values[fit.model.places_of_motors]
        yield (
            f"the motors' torques act {1e3 * late[0]:.2g} ms (inner joint) and {1e3 * late[1]:.2g} ms (outer joint) "
            f"after their record, in the outer joint {100.0 * imbalance:+.2g} % more strongly than in the inner one"
        )
    if not inertia.shown or not is_determined(inertia.value, inertia.std):
        yield f"A22 is not determined {by}: take {more}"
        return
    yield f"A22 = {inertia.value:.4g} ± {inertia.std:.2g} kg m^2, determined {by}, and with it every torque in N m"


def _words_on_physical_values(
    found: Identifiability, known: Sequence[str], inertia: Inertia, once_weighed: float
) -> Iterator[str]:
    yield from map(str, found.physical_changes_without_effect)
    if inertia.relative_std > GUESSED:
        yield (
            "no mass is known but the paper's rig's: what is in N m or kg may be three times as much, or a third; with "
            f"the outer rod weighed (known.m2) it is known to ± {100.0 * CONFIDENCE * once_weighed:.2g} %"
        )
    measured = f"what was measured ({_enumerated(known)})" if known else "no physical value measured beforehand"
    if new := [symbol for symbol in found.determined_physical if symbol not in known]:
        yield f"with {measured}, these trials determine {_enumerated(new)}"
    else:
        yield f"with {measured}, these trials determine no physical value: the ones nearest to the nominal are reported"
    if found.to_measure:
        yield f"measure {_enumerated(found.to_measure)} as well to make all of them determinable (known.<symbol>)"


def _enumerated(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else "".join(names)
