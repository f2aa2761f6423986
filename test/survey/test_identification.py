# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is kept of a finished piece, and read again."""

import json
import shutil

import pytest

from cdp_ident.report.folder import REPORT
from cdp_ident.survey.identification import RECORD, Task, finished
from cdp_ident.survey.pieces import Piece


@pytest.mark.parametrize("place", ["bag", "reason", "failure"])
def test_what_a_record_says_commands_no_terminal(report_folder, tmp_path, place):
    hostile = "\x1b]0;owned\x07 \u202e and so on"
    record = {"schema": "cdp_ident/piece/1", "key": "key", "failure": "", "left_out": [{"bag": "one", "reason": "bad"}]}
    of = record if place == "failure" else record["left_out"][0]
    of[place] = hostile
    shutil.copy(report_folder / REPORT, tmp_path)
    (tmp_path / RECORD).write_text(json.dumps(record))
    found = finished(Task(Piece("rig", "day", ()), tmp_path, {}, "key"))
    assert found is not None
    said = " ".join([found.problem, found.left_out[0].bag, found.left_out[0].reason])
    assert said.isprintable()
    assert "owned" in said
