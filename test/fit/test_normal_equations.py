"""The normal equations give the steps of the whole problem."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.normal_equations import NormalEquations
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin

MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
TWIN = standard_twin(np.random.default_rng(0))
STATES = MODEL.states


@pytest.mark.parametrize("known", [(), (1,)])
@pytest.mark.parametrize("damping", [0.0, 1e-2])
def test_eliminating_initial_states_gives_the_step_of_all_normal_equations_together(known, damping):
    windows = [replace(w, start_known=k in known) for k, w in enumerate(cut_into_windows([TWIN]))]
    problem = NormalEquations(MODEL, windows, np.arange(len(TRUTH)), TRUTH)
    point = problem.evaluate(TRUTH * 1.001, [window.start for window in windows], 0.01)
    step = problem.step(point, damping)

    unknowns, count = len(TRUTH), len(windows)
    rows, residuals, weights = [], [], []
    for k, (sensitivity, residual, weight) in enumerate(
        zip(point.sensitivities, point.residuals, point.weights, strict=True)
    ):
        flat = sensitivity.reshape(-1, STATES + unknowns)
        row = np.zeros((len(flat), STATES * count + unknowns))
        if k not in known:
            row[:, STATES * k : STATES * (k + 1)] = flat[:, :STATES]
        row[:, STATES * count :] = flat[:, STATES:]
        rows.append(row)
        residuals.append(residual.ravel())
        weights.append(weight.ravel())
    assert min(weight.min() for weight in weights) < 1.0  # the limit for outliers is in it, too
    jacobian, residual, weight = (np.concatenate(part) for part in (rows, residuals, weights))
    normal = jacobian.T @ (weight[:, None] * jacobian)
    normal += damping * np.diag(np.diag(normal))
    solution = np.linalg.lstsq(normal, jacobian.T @ (weight * residual), rcond=1e-15)[0]
    assert step.values - point.values == pytest.approx(solution[STATES * count :], rel=1e-5, abs=1e-12)
    for k, (after, before) in enumerate(zip(step.starts, point.starts, strict=True)):
        assert after - before == pytest.approx(solution[STATES * k : STATES * (k + 1)], rel=1e-5, abs=1e-10)
