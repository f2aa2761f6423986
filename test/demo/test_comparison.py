# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was hidden stands beside what was found, in the units that a free swing shows."""

import pytest

from cdp_ident.demo.comparison import compare
from cdp_ident.rig.emulator.configuration import load_rig

RIG = """
parameters: {m1: 0.1, m2: 0.1, m0: 0.2, l1: 0.2, l2: 0.2, J1: 0.001, J2: 0.001, c1: 0.005, c2: 0.001}
effects: {coulomb_friction: {outer: {torque: 0.002}}, gravity_tilt: {base: {tilt: 0.01}}}
"""
A22 = 0.1 * 0.2**2 + 0.001 + 0.3 * 0.4**2
GROUPS = {
    "A23_over_A22": 0.1 * 0.4 * 0.2 / A22,
    "A33_over_A22": 0.005 / A22,
    "a1_over_A22": 0.14 / A22,
    "c1_over_A22": 0.005 / A22,
    "c2_over_A22": 0.001 / A22,
}


def report(*effects):
    """Return a report with effects, given over A22."""
    return {
        "after": {"groups": {symbol: {"value": value} for symbol, value in GROUPS.items()}},
        "effects": [
            {"name": name, "joint": joint, "parameters": {parameter: {"as_fitted": {"value": value}}}}
            for name, joint, parameter, value in effects
        ],
    }


@pytest.fixture
def rig(tmp_path):
    (tmp_path / "rig.yaml").write_text(RIG)
    return load_rig(tmp_path / "rig.yaml")


def test_what_was_found_stands_beside_what_was_hidden_torques_over_the_inertia(rig):
    found = report(("coulomb_friction", "outer", "torque", 0.002 / A22), ("gravity_tilt", "base", "tilt", 0.01))
    compared = list(compare(rig, found))
    assert len(compared) == 7
    assert all(number.found == pytest.approx(number.hidden) for number in compared)
    assert compared[5].name == "coulomb friction, outer: torque / A22"
    assert compared[5].hidden == pytest.approx(0.002 / A22)
    assert (compared[6].hidden, compared[6].unit) == (0.01, "rad")


def test_what_was_missed_and_what_is_not_there_stand_alone(rig):
    found = report(("time_offset", "outer", "delay", 0.001))
    *_, friction, tilt, delay = compare(rig, found)
    assert friction.found is tilt.found is delay.hidden is None
    assert delay.found == 0.001
