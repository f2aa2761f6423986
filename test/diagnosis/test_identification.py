"""What is said of a fit, whatever part of it cannot be computed."""

from dataclasses import replace

import numpy as np

from cdp_ident.diagnosis.identification import Identification


def test_a_trial_that_cannot_be_fitted_alone_costs_that_comparison_and_nothing_else(outcome):
    found = outcome.trace.completed
    fit = found.fit
    # The outer rod's inertia is less than what couples it to the inner one: such rods there are none.
    impossible = replace(fit, values=np.array([1.0, 0.1, *fit.values[2:]]))
    estimate = replace(found.estimate, fit=impossible)
    diagnosed = Identification.of(found.options, found.data, found.balances, found.length, estimate)
    assert diagnosed.repeatability is None
    assert np.all(np.isfinite(diagnosed.covariance))
    (failure,) = (line for line in diagnosed.failures if line.startswith("each trial alone: "))
    assert failure.endswith("cannot be computed from the parameters to begin with")


def test_values_are_not_determined_where_their_uncertainty_cannot_be_computed(outcome):
    found = outcome.trace.completed
    # Products of sensitivities so large are no numbers.
    fit = replace(found.fit, sensitivities=[1e200 * of_window for of_window in found.fit.sensitivities])
    estimate = replace(found.estimate, fit=fit)
    with np.errstate(over="ignore", invalid="ignore"):
        diagnosed = Identification.of(found.options, found.data, found.balances, found.length, estimate)
    assert np.all(np.isinf(np.diag(diagnosed.covariance)))
    assert any(line.startswith("how sure the values are: ") for line in diagnosed.failures)
