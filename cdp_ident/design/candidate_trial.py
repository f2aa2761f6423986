"""A trial that could be recorded next, and what it would show: simulated with the fitted model."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cdp_ident.design.information import curvature
from cdp_ident.design.knowledge import NEW, Knowledge
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.predictability import predictability
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.scales import GRID, WINDOW, half_width_of, pace_of
from cdp_ident.fit.smoothing import SmoothMotion
from cdp_ident.fit.windows import Window, evenly
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.parameters import GROUPS, time_unit
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_TURN = 2.0 * np.pi
_COARSE = 2.0
"""The grid on which errors are followed may be so much coarser than where the motion is measured: it is a forecast."""


@dataclass(frozen=True)
class CandidateTrial:
    """Both rods are held at rest, and let go."""

    theta1: float
    """Of the inner rod, from upright [rad]."""
    theta2: float
    """Of the outer rod, from upright [rad]."""
    weights: tuple[Weight, ...] = ()
    """Clamped to the rods; what they may be wrong by is among the unknowns of the knowledge that judges the trial."""

    @property
    def mirrored(self) -> "CandidateTrial":
        """The same on the other side of hanging."""
        return replace(self, theta1=_TURN - self.theta1, theta2=_TURN - self.theta2)


def fit_to(candidate: CandidateTrial, knowledge: Knowledge) -> Fit:
    """Return the fit that a trial would have, if the model were true and no encoder had noise.

    What the trial tells is what no window's initial state can imitate.

    Args:
        candidate: the trial.
        knowledge: gives the motion, and how the trial is recorded and fitted.

    Raises:
        IdentificationError: its motion cannot be computed.
    """
    model, values, windows = knowledge.model, knowledge.values, windows_of(candidate, knowledge)
    followed = zip(windows, predictions(model, values, windows), strict=True)
    sensitivities = [window.whitened(by_unknowns) for window, (_, by_unknowns) in followed]
    if not all(np.all(np.isfinite(sensitivity)) for sensitivity in sensitivities):
        raise IdentificationError("the motion of a trial that is let go there cannot be computed")
    shapes = [window.theta.shape for window in windows]
    return Fit(
        model=model,
        values=values,
        windows=tuple(windows),
        residuals=tuple(np.zeros(shape) for shape in shapes),
        sensitivities=tuple(sensitivities),
        weights=tuple(np.ones(shape) for shape in shapes),
        simulations=1,
        converged=True,
    )


def predictions(model: MotionModel, values: Array, windows: Sequence[Window]) -> Iterator[tuple[Array, Array]]:
    """Yield what the encoders show in each window from its start on, and the derivatives; see `MotionModel.predict`."""
    for block in model.blocks(windows):
        starts = [window.start for window in windows[block]]
        theta, by_unknowns, bounds = model.predict_together(values, starts, windows[block])
        for first, end in pairwise(bounds.tolist()):
            yield theta[first:end], by_unknowns[first:end]


def windows_of(candidate: CandidateTrial, knowledge: Knowledge) -> list[Window]:
    """Return a trial's windows, cut as a measured one's are: as long as its motion can be followed.

    The arguments are those of `fit_to`, and so is what is raised.
    """
    sampling = knowledge.sampling
    unit = time_unit(*knowledge.model.constants(knowledge.values))
    time = _times(sampling.interval, sampling.duration)
    followed = _times(_COARSE * GRID * unit, sampling.duration)
    states, of_followed = _states(candidate, knowledge, time, followed)
    window = knowledge.sampling.window or _followed_for(candidate, knowledge, followed, of_followed)
    trial = Trial("next", time, states[:, :2])
    return [
        replace(_window(trial, first, last, states[first], knowledge), weights=candidate.weights)
        for first, last in pairwise(evenly(trial, 0, len(time), window))
    ]


def _times(spacing: float, duration: float) -> Array:
    return np.asarray(spacing * np.arange(max(int(duration / spacing), 2)), dtype=np.float64)


def _values(candidate: CandidateTrial, knowledge: Knowledge) -> Array:
    """Return the values (unknowns,) as a trial shows them, with the weights that it has."""
    return knowledge.model.with_weights(knowledge.values, candidate.weights).values


def _states(candidate: CandidateTrial, knowledge: Knowledge, *times: Array) -> list[Array]:
    """Return the states (n, states) of a trial at each of several lists of times (n,) [s]."""
    model, values = knowledge.model, _values(candidate, knowledge)
    together = np.concatenate(times)
    order = np.argsort(together, kind="stable")
    grid = TimeGrid.over(together[order], knowledge.sampling.step)
    start = model.initial_state(np.array([candidate.theta1, candidate.theta2, 0.0, 0.0]))
    still = np.zeros(2 * grid.steps + 1)
    states = np.empty((len(together), model.states))
    problem = InitialValueProblem(model.coefficients(values), start, grid, still, model.acting(values, NEW))
    states[order] = motions([problem], shown=False).states
    if not np.all(np.isfinite(states)):
        raise IdentificationError("the motion of a trial that is let go there cannot be computed")
    return np.split(states, np.cumsum([len(each) for each in times])[:-1])


def _followed_for(candidate: CandidateTrial, knowledge: Knowledge, time: Array, states: Array) -> float:
    """Return for how long a trial's motion can be followed [s], given states (n, states) at times (n,)."""
    sampling = knowledge.sampling
    length, gravity = knowledge.model.constants(knowledge.values)
    unit = time_unit(length, gravity)
    motion = SmoothMotion(
        time=time,
        values=states[None, :, :2],
        rates=states[None, :, 2:4],
        known=np.ones(len(time), dtype=bool),
        noise=np.zeros((2, 2)),
        per_knot=1.0,
    )
    groups = _values(candidate, knowledge)[: len(GROUPS)]
    speed = float(np.sqrt(np.mean(motion.rates**2)))
    noise = float(np.sqrt(np.mean(sampling.noise**2)))
    own = half_width_of(sampling.interval, noise, speed, pace_of(motion), unit)
    half_width, longest = min(own, sampling.half_width), WINDOW * unit
    found = predictability(motion, groups, length, gravity, sampling.noise, sampling.interval, half_width, longest)
    return max(found, sampling.shortest_window)


def _window(trial: Trial, first: int, last: int, start: Array, knowledge: Knowledge) -> Window:
    since = trial.time[first:last] - trial.time[first]
    grid = TimeGrid.over(since, knowledge.sampling.step)
    return Window(
        trial=NEW,
        first=first,
        begin=float(trial.time[first]),
        time=since,
        theta=trial.theta[first:last],
        grid=grid,
        u=np.zeros(2 * grid.steps + 1),
        start=start,
    )


def information_of(fit: Fit, noise: float) -> Array:
    """Return the Fisher information (unknowns, unknowns) of a trial whose angles have such a noise [rad]."""
    return curvature(fit) / noise**2
