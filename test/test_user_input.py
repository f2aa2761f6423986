# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import pytest

from cdp_ident.errors import OptionError
from cdp_ident.user_input import refuse_unknown


def test_known_names_pass():
    refuse_unknown(["L", "g"], {"g", "L"}, "parameter")


@pytest.mark.parametrize(
    ("name", "known", "words"),
    [
        ("baudrate", ["baud", "port"], "did you mean 'baud'?"),
        ("M1", ["m1", "m2"], "did you mean 'm1'?"),
        ("zzz", ["port", "baud"], "known are baud, port"),
        ("zzz", [], "none is known here"),
    ],
)
def test_an_unknown_name_is_told_with_the_nearest_known_one(name, known, words):
    with pytest.raises(OptionError, match="unknown key") as caught:
        refuse_unknown([name], known, "key in 'rig.yaml'")
    assert words in str(caught.value)
