# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever stands in a bag: a trial, or one clear error."""

import numpy as np
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from cdp_ident.errors import CdpIdentError
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions

START = 1_700_000_000_000_000_000
KINDS = ("constant", "noise", "walk", "jumps", "huge", "nan", "steps")


def joint(kind, n, generator):
    if kind == "constant":
        return np.full(n, generator.normal())
    if kind == "noise":
        return generator.normal(0, 10 ** generator.uniform(-6, 3), n)
    if kind == "walk":
        return np.cumsum(generator.normal(0, 0.05, n))
    if kind == "jumps":
        return generator.choice([-np.pi, 0.0, np.pi, 1e9], n)
    if kind == "huge":
        return generator.normal(0, 1e5, n)
    if kind == "nan":
        return np.where(generator.random(n) < 0.3, generator.choice([np.nan, np.inf, -np.inf], n), 1.0)
    return np.round(np.cumsum(generator.normal(0, 0.2, n)))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.tuples(st.sampled_from(KINDS), st.sampled_from(KINDS), st.sampled_from(KINDS)),
    st.integers(1, 1200),
    st.integers(0, 2**32 - 1),
    st.sampled_from([0.0, 0.001, 0.1, 30.0]),
    st.sampled_from(["refuse", "warn"]),
)
@example(("huge", "huge", "huge"), 411, 0, 30.0, "warn")
def test_any_numbers_give_a_trial_or_one_clear_error(make_bag, kinds, n, seed, disorder, conventions):
    generator = np.random.default_rng(seed)
    positions = np.column_stack([joint(kind, n, generator) for kind in kinds])
    stamps = START + np.arange(n) * 5_000_000 + np.round(generator.normal(0, disorder * 1e9, n)).astype(np.int64)
    bag = make_bag(stamps, positions, ("inner_joint", "outer_joint", "cart_joint"))
    try:
        trial = load_trial(bag, TrialOptions(conventions=conventions, shortest=0.5))
    except CdpIdentError as error:
        assert "\n" not in str(error).strip()  # noqa: PT017
        return
    assert trial.duration >= 0.4
    assert np.all(np.diff(trial.time) > 0)
    assert np.all(np.isfinite(trial.theta))
    assert np.all(np.isfinite(trial.cart))
