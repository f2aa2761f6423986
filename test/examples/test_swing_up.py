# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import lqr
import numpy as np
import pytest
import swing_up

from cdp_ident.configuration.fitted_model import fitted_model
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.errors import OptionError
from cdp_ident.model.motions import accelerations_at
from reference.pendulum import TABLE_5

EFFECTS = {
    "effects.coulomb_friction.inner.torque": 0.002,
    "effects.load_friction.outer.lever": 0.001,
    "effects.load_friction.outer.mass": 0.2,
    "effects.quadratic_friction.inner.coefficient": 1e-3,
    "effects.air_drag.outer.variant": "strips",
    "effects.air_drag.outer.coefficient": 1e-4,
    "effects.geared_rotor.outer.coupling": 1e-3,
    "effects.gravity_tilt.base.tilt": 0.01,
    "effects.pivot_compliance.base.compliance": 1e-4,
}
needs_casadi = pytest.mark.skipif(swing_up.casadi is None, reason="CasADi is not installed")


@needs_casadi
def test_casadi_gets_the_equations_of_motion_that_the_package_simulates():
    fitted = fitted_model(TABLE_5 | EFFECTS, "rig")
    motion = swing_up.RodsMotion(fitted)
    assert motion.left_out == []
    rng = np.random.default_rng(0)
    for _ in range(5):
        state, u = rng.uniform(-3.0, 3.0, 4), rng.uniform(-5.0, 5.0)
        acting = fitted.motion.acting(fitted.values, fitted.trial())
        expected = accelerations_at(fitted.coefficients, state[None], np.array([u]), acting)[0]
        directions = np.sign([state[2], state[3] - state[2]])
        np.testing.assert_allclose(motion.accelerations(state, u, directions).full().ravel(), expected, rtol=1e-9)


@needs_casadi
@pytest.mark.parametrize("effects", [{}, EFFECTS], ids=["paper", "effects"])
def test_it_swings_up_and_stands(tmp_path, capsys, effects):
    (tmp_path / "fitted.yaml").write_text(parameter_file(TABLE_5 | effects))
    out = tmp_path / "swing_up.json"
    assert swing_up.main([str(tmp_path / "fitted.yaml"), "--out", str(out)]) == 0
    assert "stood" in capsys.readouterr().out
    schedule = lqr.read_schedule(out, swing_up.PERIOD)
    np.testing.assert_allclose(schedule.states[0, :3], [0.0, np.pi, np.pi])
    assert np.abs(schedule.states[-1, 1:3]).max() < 0.05


@needs_casadi
def test_a_motion_keeps_to_the_laws_and_to_the_limits_of_the_drive():
    fitted, period = fitted_model(TABLE_5, "rig"), swing_up.PERIOD
    schedule = swing_up.swing_up_schedule(fitted, swing_up.Design(delay=0))
    x, speed, a = schedule.states[:, [0, 3, 6]].T
    assert max(np.abs(x).max() / 0.5, np.abs(speed).max() / 3.0, np.abs(a).max() / 20.0) < swing_up.SHARE + 5e-3
    np.testing.assert_allclose(np.diff(x), (speed[1:] + speed[:-1]) / 2 * period, atol=1e-4)
    rates = schedule.states[:, 4:6]
    theta = np.column_stack([schedule.states[:, 1:3], rates])
    alphas = accelerations_at(fitted.coefficients, theta, a)
    np.testing.assert_allclose(np.diff(rates, axis=0) / period, (alphas[1:] + alphas[:-1]) / 2, atol=0.5)


@needs_casadi
def test_what_no_drive_can_do_is_said_in_one_line():
    weak = swing_up.Drive(acceleration=0.01, speed=0.01, rail=0.01)
    with pytest.raises(OptionError, match="no motion"):
        swing_up.swing_up_schedule(fitted_model(TABLE_5, "rig"), swing_up.Design(drive=weak))


def test_without_casadi_it_says_what_is_missing(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(swing_up, "casadi", None)
    (tmp_path / "fitted.yaml").write_text(parameter_file(TABLE_5))
    with pytest.raises(SystemExit) as end:
        swing_up.main([str(tmp_path / "fitted.yaml")])
    assert end.value.code == 2
    assert "pip install casadi" in capsys.readouterr().err
