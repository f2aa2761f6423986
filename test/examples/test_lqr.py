import importlib.util
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.model.parameters import NOMINAL
from reference import pendulum
from reference.pendulum import TABLE_5

EXAMPLE = Path(__file__).parents[2] / "examples/lqr.py"
EFFECTS = {
    "effects.coulomb_friction.inner.torque": 0.001,
    "effects.air_drag.outer.variant": "strips",
    "effects.air_drag.outer.coefficient": 1e-4,
    "effects.joint_spring.outer.stiffness": 0.01,
    "effects.joint_spring.outer.torque": 0.0,
    "effects.gravity_tilt.base.tilt": 0.02,
}


@pytest.fixture(scope="module")
def lqr():
    spec = importlib.util.spec_from_file_location("lqr", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def fitted(tmp_path):
    def write(values):
        path = tmp_path / "fitted.yaml"
        path.write_text(parameter_file(values))
        return str(path)

    return write


@pytest.mark.parametrize(
    ("values", "within"),
    [(NOMINAL, 0.01), (TABLE_5, 0.01), (TABLE_5 | EFFECTS, 3.0)],
    ids=["nominal", "paper", "effects"],
)
def test_it_balances_from_five_degrees(lqr, fitted, capsys, values, within):
    assert lqr.main([fitted(values), "--lean", "5"]) == 0
    balanced = capsys.readouterr().out.splitlines()[-1]
    assert float(balanced.split("within ")[1].split()[0]) < within


def test_it_says_that_the_rods_fell_where_they_lean_too_much(lqr, fitted, capsys):
    assert lqr.main([fitted(NOMINAL), "--lean", "25"]) == 1
    assert "fell" in capsys.readouterr().out


def test_the_rig_that_it_balances_is_the_lagrangian_s(lqr, fitted):
    model = lqr.read_fitted_model(Path(fitted(TABLE_5)), "lqr")
    linear = lqr.linearize(model.coefficients, (0.0, 0.0))
    deviations, inputs = lqr.balance(model, linear, lqr.design(linear), 0.08, 0.5)
    # Between two commands the acceleration is constant, so the Lagrangian's rods can be moved piece by piece.
    time = pendulum.TIME
    rods = np.array([0.08, 0.08, 0.0, 0.0])
    for deviation, u in zip(deviations, inputs, strict=True):
        np.testing.assert_allclose(deviation[[1, 2, 4, 5]], rods, atol=1e-6)
        rods = pendulum.motion(TABLE_5, rods, np.array([0.0, lqr.PERIOD]), cart=float(u) * time**2 / 2)[-1]
    position = np.cumsum(np.cumsum(inputs)) * lqr.PERIOD**2
    np.testing.assert_allclose(deviations[1:, 0], (position - np.cumsum(inputs) * lqr.PERIOD**2 / 2)[:-1], atol=1e-12)


def test_a_file_that_is_no_model_is_refused(lqr, fitted, capsys):
    with pytest.raises(SystemExit) as end:
        lqr.main([fitted({"m1": 0.1})])
    assert end.value.code == 2
    assert "m2" in capsys.readouterr().err
