"""The model as the refinement sees it: the motion, and its derivatives, that follow from the numbers it adjusts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import groupby

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.model_unknowns import ModelUnknowns
from cdp_ident.fit.weighted import Weighted
from cdp_ident.fit.windows import Window
from cdp_ident.model.effects.bending import Load
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.effects.effect import TorqueEffect
from cdp_ident.model.effects.play import Turned
from cdp_ident.model.effects.readings import encoder_readings
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.initial_value_problem import InitialValueProblem
from cdp_ident.model.lane_rows import LANES
from cdp_ident.model.parameters import COEFFICIENTS, GROUPS, coefficients_of
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import NO_TORQUES, Torques
from cdp_ident.model.trajectories import Derivatives, end_to_end
from cdp_ident.model.trajectory import accelerations_at
from cdp_ident.model.unknowns import ChainRule
from cdp_ident.model.weights import Weight

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_A23, _OUTER_MOMENT, _GRAVITY = (COEFFICIENTS.index(name) for name in ("A23_over_A22", "m2_l2_over_A22", "g"))
_TOGETHER = 8
"""Most windows that are simulated one after the other in one call of compiled code."""
LATEST = 0.05
"""No encoder is later or earlier than this [s]."""


@dataclass(frozen=True)
class MotionModel(ModelUnknowns):
    """The paper's model with any effects."""

    @cached_property
    def states(self) -> int:
        """Size of a state: theta1, theta2, omega1, omega2, and those that effects add; see `Torques.states`."""
        return RODS_STATES + sum(a.effect.states for a in self.effects if isinstance(a.effect, TorqueEffect))

    @cached_property
    def start_penalty(self) -> Array:
        """(states,) what the square of each number of a window's initial state adds to the cost [rad^2]."""
        own = [1.0 / a.effect.start_std**2 for a in self.effects if isinstance(a.effect, TorqueEffect)
               for _ in range(a.effect.states)]  # fmt: skip
        return self.penalty_of_errors * np.array([0.0] * RODS_STATES + own)

    def initial_state(self, start: Array) -> Array:
        """Return an initial state of this model's size, given one of another model: what effects bring is zero."""
        if len(start) == self.states:
            return start
        return np.concatenate([start[:RODS_STATES], np.zeros(self.states - RODS_STATES)])

    def coefficients(self, values: Array) -> Array:
        """Return the model's coefficients (7,) under given values of the unknowns."""
        return coefficients_of(values[: len(GROUPS)], *self.constants(values))

    def torques(self, values: Array, trial: int, carried: float = 0.0) -> Torques:
        """Return the torques of the effects in a trial, and as directions their fitted parameters.

        The mass of the rods' weights in it, over the inertia about the cart's joint, is `carried` [1/m^2].
        """
        if trial not in self._torques_in:
            self._torques_in[trial] = self._lay_out_torques(trial)
        laid_out, places, fitted = self._torques_in[trial]
        parameters = laid_out.values.copy()
        parameters[places] = values[fitted]
        length, _ = self.constants(values)
        constants = effect_constants(self.coefficients(values), length, self.mechanism.outer_length, carried)
        return replace(laid_out, values=parameters, constants=constants)

    @cached_property
    def _torques_in(self) -> dict[int, tuple[Torques, tuple[Indices, Indices], Indices]]:
        """What `torques` has laid out, by trial: their layout does not depend on the values of the unknowns."""
        return {}

    def _lay_out_torques(self, trial: int) -> tuple[Torques, tuple[Indices, Indices], Indices]:
        """Return the torques in a trial, where among their parameters the fitted ones are, and these unknowns."""
        chosen: list[tuple[TorqueEffect, Sequence[float]]] = []
        directions: list[tuple[int, int]] = []
        fitted: list[int] = []
        for index, active in enumerate(self.effects):
            if isinstance(active.effect, TorqueEffect) and active.trial in (None, trial):
                place, parameters = self.places(index), active.effect.parameters
                directions += [(len(chosen), k) for k, p in enumerate(parameters) if not p.fixed]
                fitted += range(place.start, place.stop)
                chosen.append((active.effect, [p.typical for p in parameters]))
        rows, columns = np.array(directions, dtype=np.int64).reshape(-1, 2).T
        return Torques.of(chosen, NO_TORQUES.constants, directions), (rows, columns), np.array(fitted, dtype=np.int64)

    def predict(
        self,
        values: Array,
        start: Array,
        window: Window,
        derivatives: Derivatives = "all",
        turned: Turned | None = None,
    ) -> tuple[Array, Array]:
        """Return the angles that the encoders show in a window, and their derivatives.

        Args:
            values: (unknowns,) values of the unknowns.
            start: state at the window's beginning.
            window: gives the trial and the times.
            derivatives: which are wanted: "start" for those by the initial state and the encoders' zeros, for which
                less is computed.
            turned: by what encoders with play were turned before, where the window goes on from another one.

        Returns:
            Angles (n, 2) [rad] and their derivatives (n, 2, states + unknowns) by the initial state and the unknowns,
            zero where they are not wanted; (n, 2, 0) where none are.
        """
        theta, by_unknowns, _ = self.predict_together(values, [start], [window], derivatives, turned)
        return theta, by_unknowns

    def predict_together(
        self,
        values: Array,
        starts: Sequence[Array],
        windows: Sequence[Window],
        derivatives: Derivatives = "all",
        turned: Turned | None = None,
    ) -> tuple[Array, Array, Indices]:
        """Return what `predict` does of each of several windows, their samples end to end: see `blocks`.

        The third array says where each window's samples begin, and the last one's end.
        """
        runs = _alike(windows)
        weighted = [self._weighted(values, windows[run.start].weights) for run in runs]
        problems = [
            problem
            for run, of_run in zip(runs, weighted, strict=True)
            for problem in self._problems(values, of_run, starts[run], windows[run])
        ]
        states, by_directions, bounds = end_to_end(problems, derivatives)
        shown = []
        for run, of_run in zip(runs, weighted, strict=True):
            # What an encoder shows may depend on the window's other samples, as of one with play or a delay.
            parts = [run] if not self._looks_around else [slice(k, k + 1) for k in range(run.start, run.stop)]
            for part in parts:
                samples = slice(int(bounds[part.start]), int(bounds[part.stop]))
                motion = states[samples], by_directions[samples]
                shown.append(self._as_shown(values, of_run, problems[part], motion, windows[part], derivatives, turned))
        if len(shown) == 1:
            return (*shown[0], bounds)
        thetas, by_unknowns = zip(*shown, strict=True)
        return np.concatenate(thetas), np.concatenate(by_unknowns), bounds

    def blocks(self, windows: Sequence[Window]) -> list[slice]:
        """Return which windows are best predicted together: neighbours, which are mostly of one length.

        Of twice as many as there are lanes, few lanes are idle at the end. Where windows are simulated one by one,
        blocks are of one trial and smaller: cores share them. What happens in one trial alone sets trials apart, too.
        """
        one_by_one = any(active.effect.brings_states or active.effect.curve for active in self.effects)
        if one_by_one or any(active.trial is not None for active in self.effects):
            most = _TOGETHER if one_by_one else 2 * LANES
            return [piece for part in _alike(windows) for piece in _divided(part, most)]
        return _divided(slice(0, len(windows)), 2 * LANES)

    @cached_property
    def _looks_around(self) -> bool:
        """Whether what an encoder shows at one sample depends on the motion at other instants."""
        sensors = [active.effect for active in self.effects if not isinstance(active.effect, TorqueEffect)]
        return any(effect.delays or effect.has_play or effect.bends for effect in sensors)

    def _weighted(self, values: Array, weights: tuple[Weight, ...]) -> Weighted | None:
        """Return the unknowns as weights change them, if there are any."""
        return self.with_weights(values, weights) if weights else None

    def _problems(
        self, values: Array, weighted: Weighted | None, starts: Sequence[Array], windows: Sequence[Window]
    ) -> list[InitialValueProblem]:
        """Return what gives the motion in windows of one trial."""
        if weighted:
            values = weighted.values
        coefficients = self.coefficients(values)
        torques = self.torques(values, windows[0].trial, weighted.carried if weighted else 0.0)
        return [
            InitialValueProblem(coefficients, self.initial_state(start), window.grid, window.u, torques, window.begin)
            for start, window in zip(starts, windows, strict=True)
        ]

    def _as_shown(
        self,
        values: Array,
        weighted: Weighted | None,
        problems: Sequence[InitialValueProblem],
        undelayed: tuple[Array, Array],
        windows: Sequence[Window],
        derivatives: Derivatives,
        turned: Turned | None = None,
    ) -> tuple[Array, Array]:
        """Return what the encoders show of a motion that is given with its derivatives, as `predict` does.

        Windows are of one trial; of encoders that look around there is one.
        """
        if weighted:
            values = weighted.values
        window, trial = windows[0], windows[0].trial

        def motion(delay: float) -> tuple[Array, Array]:
            states, by_directions = undelayed
            if delay:
                grid = TimeGrid.over(window.time - delay, window.grid.step, earliest=-LATEST)
                u = np.pad(window.u, (0, max(2 * grid.steps + 1 - len(window.u), 0)), mode="edge")
                states, by_directions, _ = end_to_end([replace(problems[0], grid=grid, u=u)], derivatives)
            if derivatives == "none":
                return states, by_directions
            chain_rule = self._chain_rule(values, trial)
            return states, chain_rule.by_unknowns(by_directions, self.states + len(self.names))

        def accelerations(states: Array, delay: float) -> tuple[Array, Array]:
            times = window.time - delay
            u = np.interp(times, window.grid.half_step_times(), window.u)
            given = problems[0]
            return accelerations_at(given.coefficients, states, u, given.torques, window.begin + times), u

        sensors = [
            (active.effect, active.all_values(values[self.places(index)]), self.places(index))
            for index, active in enumerate(self.effects)
            if not isinstance(active.effect, TorqueEffect) and active.trial in (None, trial)
        ]
        place = self.zero_places(trial)
        # Both absolute angles contain the inner encoder's.
        zeros = np.cumsum(values[place]) if place.start < place.stop else np.zeros(2)
        shown = window.theta[0] - zeros if len(window.theta) else None
        load = Load(*self.constants(values), accelerations)
        time = np.concatenate([window.begin + window.time for window in windows])
        theta, by_unknowns = encoder_readings(motion, sensors, time, self.states, load, shown, turned)
        if place.start < place.stop:
            theta = theta + zeros
            if derivatives != "none":
                by_unknowns[:, :, self.states + place.start] = 1.0
                by_unknowns[:, 1, self.states + place.start + 1] = 1.0
        if derivatives == "all" and weighted:
            by_unknowns[:, :, self.states :] = by_unknowns[:, :, self.states :] @ weighted.by_rig
        return theta, by_unknowns

    def _chain_rule(self, values: Array, trial: int) -> ChainRule:
        """Return how the angles' derivatives by the unknowns follow from those by the directions, in a trial.

        Of the coefficients, the outer moment m2 l2 is A23 / L.
        """
        if trial not in self._unknowns_in:
            self._unknowns_in[trial] = self._lay_out_unknowns(trial)
        unknown_of, direction, unknown = self._unknowns_in[trial]
        length, _ = self.constants(values)
        factor = np.array([1.0 / length, -values[_A23] / length**2])
        return ChainRule(unknown_of, direction, unknown, factor[: len(unknown)])

    @cached_property
    def _unknowns_in(self) -> dict[int, tuple[Indices, Indices, Indices]]:
        """What `_chain_rule` has laid out, by trial."""
        return {}

    def _lay_out_unknowns(self, trial: int) -> tuple[Indices, Indices, Indices]:
        """Return the unknown of each direction, and where the outer moment contributes to others, by which one each."""
        states, names = self.states, self.base_names
        of_coefficients = np.full(len(COEFFICIENTS), -1)
        of_coefficients[: len(GROUPS)] = np.arange(len(GROUPS))
        if self.gravity_free:
            of_coefficients[_GRAVITY] = names.index("g")
        of_effects = [
            place
            for index, active in enumerate(self.effects)
            if isinstance(active.effect, TorqueEffect) and active.trial in (None, trial)
            for place in range(*self.places(index).indices(len(self.names)))
        ]
        unknowns = np.concatenate([of_coefficients, np.array(of_effects, dtype=np.int64)])
        unknown_of = np.concatenate([np.arange(states), np.where(unknowns < 0, -1, states + unknowns)])
        unknown = states + np.array([_A23, *([names.index("L")] if self.length_free else [])])
        return unknown_of, np.full(len(unknown), states + _OUTER_MOMENT), unknown


def _alike(windows: Sequence[Window]) -> list[slice]:
    """Return which neighbours are of one trial, with the same weights."""
    first, runs = 0, []
    for _, run in groupby(windows, key=lambda window: (window.trial, window.weights)):
        end = first + sum(1 for _ in run)
        runs.append(slice(first, end))
        first = end
    return runs


def _divided(part: slice, most: int) -> list[slice]:
    """Divide neighbours into blocks of so many at most, equally large if possible."""
    first, size = part.start, part.stop - part.start
    count = -(-size // most)
    return [slice(first + size * k // count, first + size * (k + 1) // count) for k in range(count)]
