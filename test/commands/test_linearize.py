# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import json

import numpy as np
import pytest
from scipy.signal import StateSpace

from cdp_ident.commands.linearize import main
from cdp_ident.configuration.fitted_model import read_fitted_model
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.model.linear import linearize
from cdp_ident.model.parameters import NOMINAL

EFFECTS = {
    "effects.joint_spring.outer.stiffness": 0.01,
    "effects.joint_spring.outer.torque": 0.0,
    "effects.coulomb_friction.inner.torque": 0.002,
    "effects.encoder_offset.inner.offset": 0.01,
}


@pytest.fixture
def fitted(tmp_path):
    """A file of a fitted model with effects."""
    path = tmp_path / "fitted.yaml"
    path.write_text(parameter_file(NOMINAL | EFFECTS | {"std.m1": 0.1, "determined.m1": False}))
    return path


@pytest.mark.parametrize("at", EQUILIBRIA)
def test_the_file_holds_the_linear_model_of_the_fitted_one(fitted, tmp_path, capsys, at):
    assert main([str(fitted), "--at", at, "--out", str(tmp_path / "new/linear.json")]) == 0
    content = json.loads((tmp_path / "new/linear.json").read_text())
    model = read_fitted_model(fitted, "linearize")
    expected = linearize(model.coefficients, EQUILIBRIA[at], model.motion.acting(model.values, model.trial()))
    system = StateSpace(*(np.array(content[name]) for name in "ABCD"))
    np.testing.assert_array_equal(system.A, expected.A)
    np.testing.assert_array_equal(system.B, expected.B)
    assert (content["at"], content["theta1_rad"]) == (at, expected.theta[0])
    assert list(content["states"]) == ["x", "theta1", "theta2", "x'", "theta1'", "theta2'"]
    assert content["controllable"] is True
    eigenvalues = np.linalg.eigvals(system.A)
    for mode in content["modes"]:
        assert np.abs(eigenvalues - complex(mode["real_per_s"], mode["imaginary_per_s"])).min() < 1e-9
    assert str(tmp_path / "new/linear.json") in capsys.readouterr().out


def test_the_matrices_are_printed_and_what_was_left_out(fitted, capsys):
    assert main([str(fitted)]) == 0
    printed = capsys.readouterr().out
    model = read_fitted_model(fitted, "linearize")
    expected = linearize(model.coefficients, EQUILIBRIA["upright"], model.motion.acting(model.values, model.trial()))
    for value in (*expected.A[4:, 1:3].flat, *expected.B[4:].flat):
        assert f"{value:.6g}" in printed
    left_out = [line for line in printed.splitlines() if line.startswith("Left out")]
    assert len(left_out) == 2
    assert "dry friction (inner joint)" in left_out[0]


def test_a_file_that_is_there_is_replaced_only_by_force(fitted, tmp_path, refused):
    out = tmp_path / "linear.json"
    out.write_text("mine")
    assert "--force" in refused(main, [fitted, "--out", out])
    assert out.read_text() == "mine"
    assert main([str(fitted), "--out", str(out), "--force"]) == 0
    assert json.loads(out.read_text())["schema"] == "cdp_ident/linear_model/1"
    assert "is a folder" in refused(main, [fitted, "--out", tmp_path, "--force"])


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (parameter_file({"m1": 0.1}), "m2"),  # what else is no model is in test_fitted_model.py
        (parameter_file(NOMINAL | EFFECTS | {"effects.joint_spring.inner.stiffness": 2.0,
                                             "effects.joint_spring.inner.torque": 0.0}), "do not rest"),
    ],
)  # fmt: skip
def test_a_file_that_describes_no_model_is_refused_in_one_line(tmp_path, refused, content, told):
    path = tmp_path / "fitted.yaml"
    path.write_text(content)
    assert told in refused(main, [path])
