"""What of a report can be compared with that of another."""

import copy

from cdp_ident.report.quantities import effect_quantities, fitted_quantity


def determined(content, symbol):
    changed = copy.deepcopy(content)
    changed["after"]["physical"][symbol]["determined"] = True
    return changed


def test_groups_and_what_trials_determine_can_be_compared(content):
    assert fitted_quantity(content, "groups", "c1_over_A22").is_known
    assert fitted_quantity(determined(content, "m0"), "physical", "m0").is_known
    assert not fitted_quantity(content, "physical", "m0").is_known


def test_what_was_measured_beforehand_says_nothing_of_the_trials(content):
    measured = determined(content, "m0")
    measured["run"]["options"]["known.m0"] = 0.208
    assert not fitted_quantity(measured, "physical", "m0").is_known


def test_torques_of_effects_are_those_that_the_motion_shows(content):
    (effect,) = content["effects"]
    (quantity,) = effect_quantities(content).values()
    assert quantity.value == effect["parameters"]["torque"]["as_fitted"]["value"]
