# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import math

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.trial.options import TrialOptions


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"outer_angle": "both"}, "outer_angle is 'both': expected one of relative, absolute"),
        ({"zero": "down"}, "expected one of upright, hanging"),
        ({"conventions": "ignore"}, "expected one of refuse, warn"),
        ({"inner_sign": 0}, "inner_sign is 0: expected 1 or -1"),
        ({"shortest": -1.0}, "shortest is -1.0: expected a positive number, or 0"),
        ({"longest_gap": math.nan}, "longest_gap is nan"),
        ({"hand_torque": math.inf}, "hand_torque is inf"),
        ({"start": 5.0, "stop": 5.0}, "leave nothing"),
        ({"start": math.nan}, "leave nothing"),
        ({"topic": "/"}, "must not be empty"),
        ({"outer_joint": "inner_joint"}, "must be different joints"),
    ],
)
def test_what_makes_no_sense_is_refused_with_what_was_expected(options, message):
    with pytest.raises(OptionError, match=message):
        TrialOptions(**options)


def test_a_bag_without_a_cart_may_be_said_to_have_none():
    assert TrialOptions(cart_joint="").cart_joint == ""
