# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run that was interrupted goes on where it ended."""

import json

from benchmarks._kept import kept
from scenarios.work import length_of_a_name


def test_what_a_file_has_is_not_done_again(tmp_path):
    path = tmp_path / "new" / "results.jsonl"
    assert list(kept(length_of_a_name, ["one"], path, 60.0, 1)) == [{"job": "one", "length": 3}]
    path.write_text('{"job": "one", "length": 99}\n')
    found = {result["job"]: result["length"] for result in kept(length_of_a_name, ["one", "three"], path, 60.0, 1)}
    assert found == {"one": 99, "three": 5}
    assert [json.loads(line)["job"] for line in path.read_text().splitlines()] == ["one", "three"]


def test_what_fails_is_said_and_left_out(tmp_path, capsys):
    assert list(kept(length_of_a_name, ["bad", "good"], tmp_path / "results.jsonl", 60.0, 1)) == [
        {"job": "good", "length": 4}
    ]
    assert "bad: " in capsys.readouterr().out
