# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Each campaign keeps its promises in small, and tells a promise that is broken."""

import pytest

from fuzz.__main__ import CAMPAIGNS
from fuzz.campaign import FindingError, run
from fuzz.texts import good_texts


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_a_campaign_has_no_findings(name):
    tally = run(name, CAMPAIGNS[name], seed=1, cases=60, seconds=60.0)
    assert tally.findings == []
    assert tally.outcomes.total() > 0


@pytest.mark.parametrize(("kind", "content", "read"), good_texts(), ids=lambda value: str(value)[:20])
def test_what_is_damaged_is_good_before(tmp_path, kind, content, read):
    (tmp_path / "some").write_bytes(content)
    assert read(tmp_path / "some")


def test_a_broken_promise_is_told_with_the_key_that_brings_it_back():
    def case(generator):
        if generator.random() < 0.5:
            raise FindingError("believed")
        return "refused"

    tally = run("some", case, seed=3, cases=20, seconds=60.0)
    assert tally.findings[0].startswith("'some 3 ")
    assert "believed" in tally.findings[0]
    assert tally.outcomes["FINDING"] == len(tally.findings) > 0
