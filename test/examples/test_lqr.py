import importlib.util
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.configuration.fitted_model import fitted_model, fitted_parameters
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.model.parameters import NOMINAL
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
FRICTION = {"effects.coulomb_friction.outer.torque": 0.002}


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
    [(NOMINAL, 0.2), (TABLE_5, 0.2), (TABLE_5 | EFFECTS, 3.0)],
    ids=["nominal", "paper", "effects"],
)
def test_it_balances_from_five_degrees(lqr, fitted, capsys, values, within):
    assert lqr.main([fitted(values), "--lean", "5"]) == 0
    balanced = capsys.readouterr().out.splitlines()[-1]
    assert float(balanced.split("within ")[1].split()[0]) < within


def test_it_says_that_the_rods_fell_where_they_lean_too_much(lqr, fitted, capsys):
    assert lqr.main([fitted(NOMINAL), "--lean", "25"]) == 1
    assert "fell" in capsys.readouterr().out


def stands(lqr, rig, controller, seed, seconds):
    """Return whether a rig stands so long from a start within three degrees, with its cart within its rail."""
    lean = np.radians(np.random.default_rng(seed).uniform(-3.0, 3.0, 2))
    deviations, _ = lqr.balance(rig, controller, lean, seconds)
    return len(deviations) == round(seconds / lqr.PERIOD) and np.abs(deviations[:, 0]).max() < 0.45


@pytest.mark.parametrize("effects", [{}, EFFECTS, FRICTION], ids=["none", "many", "friction"])
def test_a_controller_that_knows_no_effect_balances_a_rig_that_has_some(lqr, effects):
    controller = lqr.Controller(lqr.upright(fitted_model(TABLE_5, "known")))
    rig = fitted_model(TABLE_5 | effects, "rig")
    assert all(stands(lqr, rig, controller, seed, 5.0) for seed in range(4))


def test_it_stands_where_every_third_sample_is_lost(lqr):
    class Losing(lqr.Controller):
        number, last = 0, 0.0

        def command(self, deviation, samples=1):
            self.number += 1
            if self.number % 3:
                self.last = super().command(deviation, 2 if self.number % 3 == 1 and self.number > 1 else 1)
            return self.last

    rig = fitted_model(TABLE_5 | FRICTION, "rig")
    assert all(stands(lqr, rig, Losing(lqr.upright(rig)), seed, 5.0) for seed in range(4))


def test_turns_of_the_rods_are_none_of_its_business(lqr):
    controller = lqr.Controller(lqr.upright(fitted_model(TABLE_5, "rig")))
    turned = controller.deviation(np.array([0.1, 2 * np.pi + 0.02, -4 * np.pi - 0.03]))
    np.testing.assert_allclose(turned, [0.1, 0.02, -0.03], atol=1e-12)


@pytest.mark.campaign
@pytest.mark.parametrize("effects", [FRICTION, EFFECTS], ids=["friction", "many"])
def test_what_was_identified_from_free_swings_balances_the_rig_for_a_minute_from_twenty_starts(lqr, finished, effects):
    report = finished.content_of(finished.of_example_bags())
    values = {parameter.name: parameter.value for parameter in fitted_parameters(report)}
    controller = lqr.Controller(lqr.upright(fitted_model(values, "identified")))
    rig = fitted_model(TABLE_5 | effects, "rig")
    stood = [stands(lqr, rig, controller, seed, 60.0) for seed in range(20)]
    assert all(stood)


def test_a_file_that_is_no_model_is_refused(lqr, fitted, capsys):
    with pytest.raises(SystemExit) as end:
        lqr.main([fitted({"m1": 0.1})])
    assert end.value.code == 2
    assert "m2" in capsys.readouterr().err
