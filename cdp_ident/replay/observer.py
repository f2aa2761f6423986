# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The velocities of a rig whose positions are measured: a Kalman filter of the fitted model, sample by sample."""

import math
from collections.abc import Sequence

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from cdp_ident.rig.joints import HANGING

_NOISE = np.array([4e-4, 4e-4, 5e-6])
"""Of the positions of inner joint, outer joint and cart: half a count of 8000 a turn, and of 0.01 mm [rad, m]."""
_UNKNOWN = 0.03
"""What the model does not know changes the rods' speeds by so much within sqrt(L / g) [sqrt(g / L)] …"""
_JERK = 0.25
"""… and whatever moves the cart changes its acceleration by so much [g]."""
_FASTEST = 5.0
"""Standard deviation of the rods' speeds before anything is known of them [sqrt(g / L)]."""
_OWN = 1.0
"""Of states that effects bring, at most [their units]."""
_FEWEST = 4
"""Samples until a velocity is told: that of two is a difference of raw values."""
_LONGEST = 0.5
"""After a gap of more than this it begins anew [sqrt(L / g)]."""


class Observer:
    """Estimates velocities by an extended Kalman filter (Gelb, Applied Optimal Estimation, 1974, section 6.1).

    Between samples the rods move as the model has it: dry friction, joints that stick and states of effects included.
    The cart's acceleration is a random walk, whatever drives it, and moves the rods. What the encoders' errors add to
    the readings is the model's, too.
    """

    def __init__(self, model: FittedModel) -> None:
        """Begin with the first sample."""
        self._coefficients = model.coefficients
        self._effects = model.motion.acting(model.values, model.trial()).without_directions()
        length, gravity = self._coefficients[-2:].tolist()
        unit = math.sqrt(length / gravity)
        n = self._effects.states
        own = [min(state.start_std, _OWN) for effect in self._effects.effects for state in effect.law.states]
        speeds = 2 * [_FASTEST / unit]
        self._begin_std = np.array([*_NOISE[:2], *speeds, *own, _NOISE[2], length / unit, gravity])
        self._longest = _LONGEST * unit
        self._unknown = np.zeros(n + 3)
        """Variance that a second adds to the state: that of the rods and their effects (n), x, its rate and its second
        one."""
        self._unknown[2:RODS_STATES] = _UNKNOWN**2 / unit**3
        self._unknown[-1] = (_JERK * gravity) ** 2 / unit
        self._last_ns = -math.inf
        for stamp_ns in (0, 1):
            self.update(stamp_ns, HANGING)  # compiles, before the rig moves
        self._last_ns = -math.inf

    def update(self, stamp_ns: int, positions: Sequence[float]) -> tuple[float, ...]:
        """Take the next positions of cart [m], inner and outer joint [rad]; return their velocities.

        There are none of the first three samples, nor of those after a gap or a step back of time.
        """
        since, self._last_ns = (stamp_ns - self._last_ns) * 1e-9, stamp_ns
        cart, inner, outer = positions
        if not (0.0 < since <= self._longest and self._follow(since, np.array([inner, outer, cart]))):
            self._state = np.zeros(len(self._begin_std))
            self._state[:2], self._state[-3] = (inner, inner + outer), cart
            self._covariance, self._seen = np.diag(self._begin_std**2), 0
        self._seen += 1
        if self._seen < _FEWEST:
            return ()
        omega1, omega2 = self._state[2:4].tolist()
        return float(self._state[-2]), omega1, omega2 - omega1

    def _follow(self, since: float, measured: Array) -> bool:
        """Go on to a sample (3,) of inner joint, outer joint and cart that was taken [s] later; tell whether it can."""
        n, state = self._effects.states, self._state
        steps = max(1, round(since / DEFAULT_STEP))
        grid = TimeGrid(since / steps, steps, np.array([float(steps)]))
        pushes = [np.full(2 * steps + 1, state[-1] + more) for more in (0.0, 1.0)]
        moved = motions(
            [InitialValueProblem(self._coefficients, state[:n], grid, u, self._effects) for u in pushes], derive=True
        )
        if not np.all(np.isfinite(moved.ends)):
            return False
        F, G = np.zeros((n + 3, n + 3)), np.zeros((3, n + 3))
        F[:n, :n], F[:n, -1] = moved.ends_by[0], moved.ends[1] - moved.ends[0]
        F[n:, n:] = [[1.0, since, 0.5 * since**2], [0.0, 1.0, since], [0.0, 0.0, 1.0]]
        G[:2, :n], G[:2, -1] = moved.by[0], moved.readings[1] - moved.readings[0]
        G[2] = F[-3]
        expected = np.concatenate([moved.ends[0], F[n:, n:] @ state[n:]])
        shown = np.array([*moved.readings[0], expected[-3]])
        # Readings are those of the state before: encoders may be late, and noise of the speeds shows in the next one.
        to_readings = self._covariance @ G.T
        gain = np.linalg.solve(G @ to_readings + np.diag(_NOISE**2), (F @ to_readings).T).T
        self._state = expected + gain @ (measured - shown)
        covariance = F @ self._covariance @ F.T - gain @ (F @ to_readings).T + np.diag(self._unknown * since)
        self._covariance = 0.5 * (covariance + covariance.T)
        return bool(np.all(np.isfinite(self._state)))
