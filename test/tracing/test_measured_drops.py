# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Three measured drops of a rig with geared drives: what two of them show predicts the third."""

from pathlib import Path

import pytest

from cdp_ident.commands.import_csv import main
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.pipeline.identify import identify_and_trace
from cdp_ident.trial.load import load_trial

DROPS = Path(__file__).parents[3] / "shared" / "data" / "dfki_drops"
NOMINAL = {"L": 0.3, "m1": 0.608, "m2": 0.63, "m0": 0.0, "l1": 0.275, "l2": 0.166, "J1": 8.75e-3, "J2": 7.9e-3}
"""From the drawings."""


@pytest.mark.campaign
@pytest.mark.skipif(not DROPS.exists(), reason=f"the measured drops are not at {DROPS}")
def test_friction_in_both_joints_and_the_geared_rotor_are_found_in_two_drops_and_predict_the_third(tmp_path):
    bags = [tmp_path / str(number) for number in (1, 2, 3)]
    for bag in bags:
        given = [str(DROPS / f"drop{bag.name}.csv.gz"), "--zero", "hanging", "--length", "0.3"]
        assert main([*given, "--out", str(bag)]) == 0
    first, second, third = (load_trial(bag) for bag in bags)
    _, traced = identify_and_trace([first, second], [third], IdentifyOptions(prior=Prior(nominal=NOMINAL)))
    found = {effect.active.effect.key: effect for effect in traced.effects}
    friction = [next(key for key in found if "friction" in key and joint in key) for joint in ("inner", "outer")]
    assert "geared_rotor.outer" in found
    # More than noise remains, so no name is sure.
    assert all(effect.certainty != "named" for effect in found.values())
    before, after = (traced.errors[stage].holdout.rmse for stage in ("refined", "effects"))
    assert after < 0.2 * before
    for key, elsewhere in zip(friction, (0.093, 0.09), strict=True):
        torque = found[key].parameters[0]
        assert abs(torque.value - elsewhere) < 2.0 * torque.std
