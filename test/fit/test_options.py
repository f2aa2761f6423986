# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a user may choose."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.errors import OptionError
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.search.options import IGA


def test_without_method_the_search_is_short_and_with_one_the_paper_s():
    short = IdentifyOptions()
    assert short.search.generations < 10
    assert short.window == 0.0  # what suits the rig
    assert short.span(1.7) == 1.7
    paper = IdentifyOptions(method="iga")
    assert paper.search is IGA
    assert paper.span(1.7) == 10.0
    assert IdentifyOptions(genetic=replace(IGA, generations=3)).search.generations == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"window": -0.1}, "window is -0.1 s; it must be at least 0.001 s, or 0 for what suits the rig"),
        ({"window": np.inf}, "window is inf s; it must be at least 0.001 s"),
        ({"window": np.nan}, "window is nan s"),
        ({"method": "ga"}, "method is 'ga'; it must be one of iga, tga"),
    ],
)
def test_options_that_cannot_be_are_refused(options, message):
    with pytest.raises(OptionError) as caught:
        IdentifyOptions(**options)
    assert message in str(caught.value)
