# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model as a fit sees it: the motion that follows from the numbers that are adjusted."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.fit.model_unknowns import ModelUnknowns
from cdp_ident.fit.windows import Window
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.forces import MOTORS
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import Motions, motions_over
from cdp_ident.model.parameters import COEFFICIENTS, GROUPS, INVERSE_INERTIA, coefficients_of
from cdp_ident.model.steps import Times


@dataclass(frozen=True)
class MotionModel(ModelUnknowns):
    """The paper's model with any effects."""

    @cached_property
    def states(self) -> int:
        """Size of a state: theta1, theta2, omega1, omega2, and those that effects add."""
        return RODS_STATES + sum(active.effect.states for active in self.effects)

    def initial_state(self, start: Array) -> Array:
        """Return an initial state of this model's size, given one of another model: what effects bring is zero."""
        if len(start) == self.states:
            return start
        return np.concatenate([start[:RODS_STATES], np.zeros(self.states - RODS_STATES)])

    def coefficients(self, values: Array) -> Array:
        """Return the model's coefficients (7,) under given values of the unknowns."""
        return coefficients_of(values[: len(GROUPS)], *self.constants(values))

    def acting(self, values: Array, trial: int, carried: float = 0.0) -> ActingEffects:
        """Return the effects in a trial, with the unknowns as directions: coefficients that are free, then parameters.

        The mass of the rods' weights in it, over the inertia about the cart's joint, is `carried` [1/m^2].
        """
        laid_out, fitted, _ = self._in_trial(trial)
        parameters = laid_out.values.copy()
        parameters[list(laid_out.parameters)] = values[fitted]
        return replace(laid_out, values=parameters, carried=carried)

    def _in_trial(self, trial: int) -> tuple[ActingEffects, Indices, Indices]:
        """Return the effects in a trial, the unknowns that their fitted parameters are, and which each direction is."""
        if trial not in self._layouts:
            there = [k for k, active in enumerate(self.effects) if active.trial in (None, trial)]
            chosen = [(e, [p.typical for p in e.parameters]) for e in (self.effects[k].effect for k in there)]
            own = np.array([at for k in there for at in range(*self.places(k).indices(len(self.names)))], dtype=int)
            of_motors = [*range(*self.places_of_motors.indices(len(self.names)))]
            if self.motors:
                chosen.insert(0, (MOTORS, [1.0 / self.mechanism.inertia, *(p.typical for p in self.of_motors)]))
                if self.inertia_free:
                    of_motors.insert(0, self.base_names.index(INVERSE_INERTIA.symbol))
            fitted = np.concatenate([of_motors, own]).astype(int)
            free = (*range(len(GROUPS)), *(COEFFICIENTS.index(name) for name in self._constants))
            laid_out = ActingEffects.of(chosen, self.mechanism.outer_length, fitted=True)
            acting = replace(
                laid_out,
                parameters=laid_out.parameters[len(laid_out.parameters) - len(fitted) :],
                coefficients=free,
            )
            unknowns = [*range(len(GROUPS)), *(self.base_names.index(name) for name in self._constants), *fitted]
            columns = np.concatenate([np.arange(self.states), self.states + np.array(unknowns)])
            self._layouts[trial] = acting, fitted, columns
        return self._layouts[trial]

    @cached_property
    def _layouts(self) -> dict[int, tuple[ActingEffects, Indices, Indices]]:
        """What `_in_trial` has laid out, by trial: it does not depend on the values of the unknowns."""
        return {}

    def columns_in(self, trial: int) -> Indices:
        """Return which unknown each direction of derivatives in a trial is, after those by the initial state."""
        return self._in_trial(trial)[2][self.states :] - self.states

    def predict(self, values: Array, start: Array, window: Window) -> Array:
        """Return the angles (n, 2) that the encoders show in a window [rad].

        Args:
            values: (unknowns,) values of the unknowns.
            start: state at the window's beginning.
            window: gives the trial and the times.
        """
        return self.motions_in(values, start[None], window).readings

    def motions_in(
        self, values: Array, starts: Array, window: Window, times: Times | None = None, derive: bool = False
    ) -> Motions:
        """Return the motions in the pieces of a window from their initial states, their samples end to end.

        Args:
            values: (unknowns,) values of the unknowns.
            starts: (pieces, states) at the beginning of each.
            window: what is followed.
            times: of its pieces; it is one by default.
            derive: whether derivatives by these states are wanted.
        """
        trial, begins = window.trial, np.array([self.initial_state(start) for start in starts])
        weighted = self.with_weights(values, window.weights)
        acting = self.acting(weighted.values, trial, weighted.carried).without_directions()
        coefficients = self.coefficients(weighted.values)
        found = motions_over(times or window.in_pieces(), coefficients, begins, acting, derive)
        place = self.zero_places(trial)
        of_zeros = self.by_zeros @ values[place] if place.start < place.stop else 0.0
        # Both absolute angles contain the inner encoder's.
        return found._replace(readings=np.cumsum(found.readings + of_zeros, axis=1), by=np.cumsum(found.by, axis=1))
