# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which maximum of the likelihood is found: from where steps begin, with unknown torques or without."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.gauss_newton import SHOWN, GaussNewton
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings
from cdp_ident.model.effects.effect import JOINTS

CLOSE_ENOUGH, ENOUGH_STEPS = 0.3, 30
"""A model is compared with others once no step changes it by more than this share of a standard deviation, or after so
many steps: one that is far from the motion needs no more to be known for that."""
FEW_STEPS = 4
"""After so many steps the best of several beginnings shows."""
SPACING, NEAR = 0.5, 0.2
"""Between nodes, in time units: where nothing is missing, and where torques are, whose impulses are at the nodes."""
_MISSING = 4.0
"""Torques are missing where the least impulses' squares are so many times what is expected of them."""
_FALLS, _HELD_STEPS = 0.03, 4
"""Torques vanish by this factor after so many steps each."""
_LESS, _STEPS_WITH_LESS = 0.03, 12
"""Share of unknown torques with which values follow the motion for longer, and so many steps."""


def most_likely(
    model: MotionModel,
    values: Array,
    recorded_with: Callable[[float], tuple[Recorded, Sequence[Array]]],
) -> WholeSwings:
    """Find the most likely values, states and standard deviations.

    It begins with no unknown torque but the least. Where torques are missing, or nothing is found so, it begins anew
    with large ones, and nodes so near to each other that what is unknown does not matter between them.

    Args:
        model: gives the motion.
        values: (unknowns,) to begin with.
        recorded_with: given the spacing of the nodes in time units, returns what was measured, and the states (nodes,
            states) of each swing to begin with, see `Swing.states`.

    Raises:
        IdentificationError: no maximum is found.
    """
    recorded, states = recorded_with(SPACING)
    try:
        search = GaussNewton(model, values, recorded, states, Noise.white(recorded.encoders, recorded.least_torque))
        search.run()
        if search.converged and np.all(search.excess < _MISSING):
            return search.found()
    except (IdentificationError, np.linalg.LinAlgError):
        pass
    recorded, states = recorded_with(NEAR)
    noise = Noise.white(recorded.encoders, recorded.large_torque)
    found = GaussNewton(model, values, recorded, states, noise).run().found()
    if not found.converged:
        raise IdentificationError(f"the most likely motion was not found in {found.steps} steps")
    return found


def best_of(
    searches: Sequence[GaussNewton],
    to_beat: float = np.inf,
    most_steps: int = ENOUGH_STEPS,
    promised: float = np.inf,
) -> tuple[WholeSwings | None, list[str]]:
    """Return what the best of several searches for one model finds: a few steps of each, and the best one to the end.

    It is None where no motion can be computed, or nothing is promised; beside it is why no motion can be.

    Args:
        searches: which differ in where they begin.
        to_beat: see `GaussNewton.run`.
        most_steps: after so many, the best one ends where it is.
        promised: a misfit that is larger than the best one's after a few steps.
    """
    begun, failures = list[GaussNewton](), list[str]()
    for search in searches:
        try:
            begun.append(search.run(min(FEW_STEPS, most_steps)))
        except (IdentificationError, np.linalg.LinAlgError) as error:
            failures.append(str(error))
    try:
        if begun:
            best = min(begun, key=lambda one: one.misfit)
            if best.misfit > promised:
                return None, failures
            return _at_instants((best if best.converged else best.run(most_steps, to_beat)).found()), failures
    except (IdentificationError, np.linalg.LinAlgError) as error:
        failures.append(str(error))
    return None, failures


def _at_instants(found: WholeSwings) -> WholeSwings:
    """Return a model whose lost counts are lost between the samples that show it: steps have no derivative by that.

    Raises:
        IdentificationError: no motion can be computed.
    """
    values, swings = found.values.copy(), zip(found.recorded.swings, found.linear, strict=True)
    lost = [(k, a) for k, a in enumerate(found.model.effects) if a.effect.at_an_instant and not a.effect.moves]
    for (index, active), (swing, linear) in product(lost, swings):
        slip, instant = values[found.model.places(index)]
        time = swing.begin + swing.time
        near = np.abs(time - instant) < swing.spacing
        if swing.trial == active.trial and np.any(near):
            time, residuals = time[near], linear.residuals[near, JOINTS.index(active.effect.joint)]
            later = time >= time[:, None]  # of each sample, which others have lost the counts if it is the first one
            squares = np.sum((residuals + slip * (later.astype(float) - (time >= instant))) ** 2, axis=1)
            values[found.model.places(index)] = slip, time[np.argmin(squares)]
    if np.all(values == found.values):
        return found
    again = GaussNewton(found.model, values, found.recorded, found.states, found.noise, CLOSE_ENOUGH).run(ENOUGH_STEPS)
    return min(found, again.found(), key=lambda one: one.misfit)


def _other_maxima(found: WholeSwings, to_beat: float = np.inf) -> list[WholeSwings]:
    """Return other maxima of the likelihood of a model that leaves more than noise, close enough to compare.

    Unknown torques follow what is autocorrelated noise, that noise follows what is motion, and a joint that dry
    friction holds is not held where torques move it. What is taken for torques in both joints may be a base that moves.

    Args:
        found: one maximum.
        to_beat: a misfit; one that will hardly be smaller need not be found.

    Raises:
        IdentificationError: no motion can be computed.
    """
    if not np.any(found.leaves_more):
        return []
    if not np.any(found.is_missing):
        return [_with_noise(found, Noise.white(found.recorded.encoders, found.recorded.least_torque))]
    others = [_without_torque(found, to_beat)]
    if not found.noise.of_base:
        moved = _with_noise(found, replace(found.noise, of_base=True))
        if moved.misfit < found.misfit - SHOWN:
            others.append(moved)
    return others


def likelier_maximum(found: WholeSwings) -> WholeSwings:
    """Return the likeliest maximum of a model's likelihood; what it is, if others cannot be computed."""
    try:
        return min([found, *_other_maxima(found, found.misfit)], key=lambda one: one.misfit)
    except (IdentificationError, np.linalg.LinAlgError):
        return found


def _with_noise(found: WholeSwings, noise: Noise) -> WholeSwings:
    """Find a maximum from where another one is, but for the noise; as far as it may be the likelier one."""
    search = GaussNewton(found.model, found.values, found.recorded, found.states, noise, CLOSE_ENOUGH)
    return search.run(ENOUGH_STEPS, found.misfit).found()


def _without_torque(found: WholeSwings, to_beat: float) -> WholeSwings:
    """Find the most likely values without unknown torques, from where they are with them.

    A joint that dry friction holds is not held where torques move it. So these vanish little by little (continuation:
    Nocedal and Wright, Numerical Optimization, 2006, section 11.3), before they are as large as they have to be.
    Where the misfit then rises by more than one for each node, they vanish at once: they may have followed
    autocorrelated noise.
    """
    recorded, torque, values = found.recorded, found.noise.torque, found.values
    states: Sequence[Array] = found.states
    noise = replace(found.noise, tails=())
    while np.any(torque > recorded.least_torque):
        torque = np.maximum(_FALLS * torque, recorded.least_torque)
        search = GaussNewton(found.model, values, recorded, states, replace(noise, torque=torque), CLOSE_ENOUGH)
        search.run(_HELD_STEPS, held=True)
        if search.found().misfit > found.misfit + recorded.nodes:
            values, states, torque = found.values, found.states, np.full(2, recorded.least_torque)
            break
        values, states = search.values, search.states
    noise = replace(noise, torque=torque)
    return GaussNewton(found.model, values, recorded, states, noise, CLOSE_ENOUGH).run(ENOUGH_STEPS, to_beat).found()


def with_less_torque(found: WholeSwings) -> WholeSwings:
    """Return a model under unknown torques of a small share of their size.

    Where something is missing that is the same each time, torques that are new at each node forget what long motions
    say of it. With less of them, values are those whose motion follows what was measured for longer (output error in
    place of prediction error: Ljung, System Identification, 1999, chapter 7), and scores tell what would explain that.

    Args:
        found: a model with its most likely values.

    Raises:
        IdentificationError: no motion can be computed.
    """
    torque = np.maximum(_LESS * found.noise.torque_with_tails, found.recorded.least_torque)
    noise = replace(found.noise, torque=torque, tails=())
    search = GaussNewton(found.model, found.values, found.recorded, found.states, noise)
    return search.run(_STEPS_WITH_LESS, held=True).found()
