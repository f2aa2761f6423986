# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is said of a fit, whatever part of it cannot be computed."""

from dataclasses import replace

import numpy as np

from cdp_ident.diagnosis.identification import Identification


def test_a_trial_that_cannot_be_fitted_alone_costs_that_comparison_and_nothing_else(outcome):
    found = outcome.trace.completed
    # The outer rod's inertia is less than what couples it to the inner one: such rods there are none.
    impossible = replace(found.whole, values=np.array([1.0, 0.1, *found.whole.values[2:]]))
    diagnosed = Identification.of(found.options, found.data, found.search, impossible, found.fit, found.covariance)
    assert diagnosed.repeatability is None
    assert np.all(np.isfinite(diagnosed.covariance))
    (failure,) = diagnosed.failures
    assert failure.startswith("each trial alone: ")
