# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which maximum of the likelihood is found: from where steps begin, with unknown torques or without."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.gauss_newton import CLOSE, MOST_STEPS, SHOWN, Search
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings

Array = npt.NDArray[np.float64]

CLOSE_ENOUGH, ENOUGH_STEPS = 0.3, 30
"""A model is compared with others once no step changes it by more than this share of a standard deviation, or after so
many steps: one that is far from the motion needs no more to be known for that."""
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
        search = Search(model, values, recorded, states, Noise.white(recorded.encoders, recorded.least_torque))
        search.run()
        if search.converged and np.all(search.excess < _MISSING):
            return search.found()
    except (IdentificationError, np.linalg.LinAlgError):
        pass
    recorded, states = recorded_with(NEAR)
    found = likely_near(model, values, recorded, states, Noise.white(recorded.encoders, recorded.large_torque))
    if not found.converged:
        raise IdentificationError(f"the most likely motion was not found in {found.steps} steps")
    return found


def likely_near(
    model: MotionModel,
    values: Array,
    recorded: Recorded,
    states: Sequence[Array],
    noise: Noise,
    close: float = CLOSE,
    most_steps: int = MOST_STEPS,
    to_beat: float = np.inf,
) -> WholeSwings:
    """Find the most likely values, states and standard deviations near given ones.

    Args:
        model: gives the motion.
        values: (unknowns,) to begin with.
        recorded: what was measured.
        states: (nodes, states) of each swing, to begin with.
        noise: to begin with.
        close: changes below this share of a standard deviation end the search.
        most_steps: after so many it ends where it is.
        to_beat: a misfit; the search ends where it will hardly be smaller.

    Raises:
        IdentificationError: no motion can be computed.
    """
    search = Search(model, values, recorded, states, noise, close)
    search.run(most_steps, to_beat)
    return search.found()


def likely_without_torque(found: WholeSwings, close: float, most_steps: int, to_beat: float) -> WholeSwings:
    """Find the most likely values without unknown torques, from where they are with them.

    A joint that dry friction holds is not held where torques move it. So these vanish little by little (continuation:
    Nocedal and Wright, Numerical Optimization, 2006, section 11.3), before they are as large as they have to be.
    Where the misfit then rises by more than one for each node, they vanish at once: they may have followed
    autocorrelated noise.

    Args:
        found: a model and its values.
        close: see `likely_near`.
        most_steps: see `likely_near`.
        to_beat: see `likely_near`.

    Raises:
        IdentificationError: no motion can be computed.
    """
    recorded, torque, values = found.recorded, found.noise.torque, found.values
    states: Sequence[Array] = found.states
    noise = replace(found.noise, tails=())
    while np.any(torque > recorded.least_torque):
        torque = np.maximum(_FALLS * torque, recorded.least_torque)
        search = Search(found.model, values, recorded, states, replace(noise, torque=torque), close)
        search.run(_HELD_STEPS, held=True)
        if search.found().misfit > found.misfit + recorded.nodes:
            values, states, torque = found.values, found.states, np.full(2, recorded.least_torque)
            break
        values, states = search.values, search.states
    return likely_near(found.model, values, recorded, states, replace(noise, torque=torque), close, most_steps, to_beat)


def likelier_maximum(found: WholeSwings) -> WholeSwings:
    """Return a model that leaves more than noise, or what it is if one begins without, where that is more likely.

    The likelihood may have several maxima: unknown torques follow what is autocorrelated noise, that noise follows what
    is motion, and a joint that dry friction holds is not held where torques move it. What is taken for torques in both
    joints may be a base that moves, if that leaves no torque in the outer one.

    Args:
        found: one maximum.
    """
    recorded = found.recorded
    try:
        if np.any(found.is_missing):
            other = likely_without_torque(found, CLOSE_ENOUGH, ENOUGH_STEPS, found.misfit)
        elif np.any(found.leaves_more):
            noise = Noise.white(recorded.encoders, recorded.least_torque)
            other = likely_near(
                found.model, found.values, recorded, found.states, noise, CLOSE_ENOUGH, ENOUGH_STEPS, found.misfit
            )
        else:
            return found
        if np.any(found.is_missing) and not found.noise.of_base:
            noise = replace(found.noise, of_base=True)
            moved = likely_near(
                found.model, found.values, recorded, found.states, noise, CLOSE_ENOUGH, ENOUGH_STEPS, found.misfit
            )
            if moved.misfit < min(found.misfit, other.misfit) - SHOWN and not moved.is_missing[1]:
                return moved
    except (IdentificationError, np.linalg.LinAlgError):
        return found
    return min(found, other, key=lambda one: one.misfit)


def values_with_less_torque(found: WholeSwings) -> Array:
    """Return the values (unknowns,) under unknown torques of a small share of their size.

    Where something is missing that is the same each time, torques that are new at each node forget what long motions
    say of it. With less of them, values are those whose motion follows what was measured for longer (output error in
    place of prediction error: Ljung, System Identification, 1999, chapter 7).

    Args:
        found: the most likely values.

    Raises:
        IdentificationError: no motion can be computed.
    """
    torque = np.maximum(_LESS * found.noise.torque_with_tails, found.recorded.least_torque)
    search = Search(
        found.model, found.values, found.recorded, found.states, replace(found.noise, torque=torque, tails=())
    )
    search.run(_STEPS_WITH_LESS, held=True)
    return search.values
