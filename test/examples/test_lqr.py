# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import lqr
import numpy as np
import pytest

from cdp_ident.configuration.fitted_model import fitted_model, fitted_parameters
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.errors import OptionError
from cdp_ident.model.parameters import NOMINAL
from reference.pendulum import TABLE_5

EFFECTS = {
    "effects.coulomb_friction.inner.torque": 0.001,
    "effects.air_drag.outer.variant": "strips",
    "effects.air_drag.outer.coefficient": 1e-4,
    "effects.joint_spring.outer.stiffness": 0.01,
    "effects.joint_spring.outer.torque": 0.0,
    "effects.gravity_tilt.base.tilt": 0.02,
}
FRICTION = {"effects.coulomb_friction.outer.torque": 0.002}


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
def test_it_balances_from_five_degrees(fitted, capsys, values, within):
    assert lqr.main([fitted(values), "--lean", "5"]) == 0
    balanced = capsys.readouterr().out.splitlines()[-1]
    assert float(balanced.split("within ")[1].split()[0]) < within


def test_it_says_that_the_rods_fell_where_they_lean_too_much(fitted, capsys):
    assert lqr.main([fitted(NOMINAL), "--lean", "25"]) == 1
    assert "fell" in capsys.readouterr().out


def controller_of(fitted, kind=lqr.Controller):
    schedule, _ = lqr.upright_schedule(fitted)
    return kind(schedule)


def stands(rig, controller, seed, seconds):
    """Return whether a rig stands so long from a start within three degrees, with its cart within its rail."""
    lean = np.radians(np.random.default_rng(seed).uniform(-3.0, 3.0, 2))
    deviations, _ = lqr.balance(rig, controller, lean, seconds)
    return len(deviations) == round(seconds / lqr.PERIOD) and np.abs(deviations[:, 0]).max() < 0.45


@pytest.mark.parametrize("effects", [{}, EFFECTS, FRICTION], ids=["none", "many", "friction"])
def test_a_controller_that_knows_no_effect_balances_a_rig_that_has_some(effects):
    controller = controller_of(fitted_model(TABLE_5, "known"))
    rig = fitted_model(TABLE_5 | effects, "rig")
    assert all(stands(rig, controller, seed, 5.0) for seed in range(2))


def test_it_stands_where_every_third_sample_is_lost():
    class Losing(lqr.Controller):
        number, last = 0, 0.0

        def command(self, measured, samples=1):
            self.number += 1
            if self.number % 3:
                self.last = super().command(measured, 2 if self.number % 3 == 1 and self.number > 1 else samples)
            return self.last

    rig = fitted_model(TABLE_5 | FRICTION, "rig")
    assert all(stands(rig, controller_of(rig, Losing), seed, 5.0) for seed in range(2))


def test_dry_friction_damps_the_regulator_as_it_would_at_one_rate_of_a_joint():
    rig = fitted_model(TABLE_5 | FRICTION, "rig")
    viscous = fitted_model(TABLE_5 | {"c2": TABLE_5["c2"] + 0.002 / lqr.SWAY}, "rig")
    (with_it, _), (without, _), (damped, _) = (
        lqr.upright_schedule(*of) for of in ((rig,), (rig, lqr.Design(friction=False)), (viscous,))
    )
    np.testing.assert_allclose(with_it.gains, damped.gains, rtol=1e-6)
    assert not np.allclose(with_it.gains, without.gains, rtol=1e-3)


def test_a_controller_that_knows_dry_friction_keeps_rods_nearer_to_upright():
    rig, sizes = fitted_model(TABLE_5 | {"effects.coulomb_friction.outer.torque": 0.006}, "rig"), list[float]()
    for friction in (True, False):
        schedule, _ = lqr.upright_schedule(rig, lqr.Design(friction=friction))
        deviations, _ = lqr.balance(rig, lqr.Controller(schedule), np.array([0.03, -0.03]), 10.0)
        sizes.append(np.abs(deviations[:, 1:]).max())
    assert sizes[0] < 0.9 * sizes[1]


def test_a_controller_that_knows_the_delay_stands_where_another_falls(monkeypatch):
    class LateCart(lqr.DrivenCart):
        waiting = (0.0,) * 5

        def command(self, acceleration):
            super().command(self.waiting[0])
            self.waiting = (*self.waiting[1:], acceleration)

    monkeypatch.setattr(lqr, "DrivenCart", LateCart)
    rig = fitted_model(TABLE_5, "rig")
    for delay, standing in ((6, True), (1, False)):
        schedule, _ = lqr.upright_schedule(rig, lqr.Design(delay=delay))
        assert all(stands(rig, lqr.Controller(schedule), seed, 5.0) for seed in range(2)) == standing


def test_errors_of_encoders_that_were_found_are_taken_off():
    errors = {"effects.encoder_offset.outer.offset": 0.05, "effects.encoder_scale.inner.scale": 0.01}
    rods = lqr.rods_shown(fitted_model(TABLE_5 | errors | FRICTION, "rig"))
    inner = np.pi + 1.01 * (0.1 - np.pi)
    np.testing.assert_allclose(rods(np.array([0.2, inner, inner + 0.3 + 0.05])), [0.2, 0.1, 0.4], atol=5e-4)


def test_a_schedule_comes_back_from_its_file_as_it_was(tmp_path):
    schedule, _ = lqr.upright_schedule(fitted_model(TABLE_5, "rig"))
    lqr.write_schedule(tmp_path / "schedule.json", schedule)
    again = lqr.read_schedule(tmp_path / "schedule.json", lqr.PERIOD)
    for name, of in vars(schedule).items():
        np.testing.assert_array_equal(getattr(again, name), of)


@pytest.mark.parametrize(
    ("text", "period", "words"),
    [("{}", 0.005, "no file of swing_up.py"), ("[1]", 0.005, "no file of swing_up.py"), (None, 0.005, "no file"),
     ("own", 0.01, "every 0.005 s")],
)  # fmt: skip
def test_what_is_no_schedule_for_these_samples_is_refused(tmp_path, text, period, words):
    path = tmp_path / "schedule.json"
    if text == "own":
        lqr.write_schedule(path, lqr.upright_schedule(fitted_model(TABLE_5, "rig"))[0])
    elif text:
        path.write_text(text)
    with pytest.raises(OptionError, match=words):
        lqr.read_schedule(path, period)


def test_turns_of_the_rods_are_none_of_its_business():
    controller = controller_of(fitted_model(TABLE_5, "rig"))
    turned = controller.deviation(np.array([0.1, 2 * np.pi + 0.02, -4 * np.pi - 0.03]))
    np.testing.assert_allclose(turned, [0.1, 0.02, -0.03], atol=1e-12)


@pytest.mark.campaign
@pytest.mark.parametrize("effects", [FRICTION, EFFECTS], ids=["friction", "many"])
def test_what_was_identified_from_free_swings_balances_the_rig_for_a_minute_from_twenty_starts(finished, effects):
    report = finished.content_of(finished.of_example_bags())
    values = {parameter.name: parameter.value for parameter in fitted_parameters(report)}
    controller = controller_of(fitted_model(values, "identified"))
    rig = fitted_model(TABLE_5 | effects, "rig")
    stood = [stands(rig, controller, seed, 60.0) for seed in range(20)]
    assert all(stood)


def test_a_file_that_is_no_model_is_refused(fitted, capsys):
    with pytest.raises(SystemExit) as end:
        lqr.main([fitted({"m1": 0.1})])
    assert end.value.code == 2
    assert "m2" in capsys.readouterr().err
