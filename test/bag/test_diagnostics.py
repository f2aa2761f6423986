# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""DiagnosticArray messages without ROS."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.bag.diagnostics import CLOCK_RATE, CLOCK_RATE_STD, read_statuses
from scenarios.device_messages import diagnostics


def test_every_status_is_read():
    first, second = read_statuses(diagnostics({"/camera": {}, "/rig1/driver": {"lost": "3"}}, "firmware on /dev/tty"))
    assert (first.name, first.clock_rate) == ("/camera", None)
    assert (second.name, second.hardware_id, second.values) == ("/rig1/driver", "firmware on /dev/tty", {"lost": "3"})


@pytest.mark.parametrize(
    ("rate", "std", "expected"),
    [
        ("-12.5", "0.5", pytest.approx((-12.5e-6, 0.5e-6))),
        ("unknown", "unknown", None),
        ("nan", "1.0", None),
        ("1.0", "inf", None),
        ("1.0", "-1.0", None),
        ("1e6", "1.0", None),
    ],
)
def test_a_clock_s_rate_is_taken_where_it_is_one(rate, std, expected):
    (status,) = read_statuses(diagnostics({"/driver": {CLOCK_RATE: rate, CLOCK_RATE_STD: std}}))
    assert status.clock_rate == expected


@given(raw=st.binary(max_size=200))
def test_arbitrary_bytes_say_nothing(raw):
    assert read_statuses(raw) == []
