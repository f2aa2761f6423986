# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A program goes on, and says in one line what became of its output, wherever that goes."""

import os
import subprocess
import sys

import pytest

PRINTS = """
import sys
from cdp_ident.command_line import entry_point
from cdp_ident.standard_streams import make_tolerant
make_tolerant()

@entry_point
def main(arguments):
    for _ in range(100_000):
        print("± 0.1 mrad")
    print("went on", file=sys.stderr)
    return 0

sys.exit(main([]))
"""


def run(redirection, **environment):
    command = ["bash", "-c", f'"$0" -c "$1" {redirection}', sys.executable, PRINTS]
    return subprocess.run(
        command, check=False, capture_output=True, text=True, env=os.environ | environment, timeout=300
    )


def test_output_to_a_full_disk_is_told_in_one_line():
    done = run("> /dev/full")
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "went on",
        "__main__: error: not all output could be written: No space left on device",
    ]


def test_a_reader_that_goes_away_is_no_error():
    done = run("| head -1; exit ${PIPESTATUS[0]}")
    assert (done.returncode, done.stdout, done.stderr) == (0, "± 0.1 mrad\n", "went on\n")


@pytest.mark.parametrize("redirection", [">&-", ">&- <&-", "2>&- >&-"])
def test_closed_streams_are_no_error(redirection):
    assert run(redirection).returncode == 0


def test_what_the_encoding_lacks_is_written_as_an_escape():
    done = run("| tail -1", PYTHONIOENCODING="ascii")
    assert done.stdout == "\\xb1 0.1 mrad\n"


def test_a_file_that_is_opened_is_not_taken_for_a_closed_stream(tmp_path):
    code = f"""
from cdp_ident.standard_streams import make_tolerant
make_tolerant()
with open({str(tmp_path / "file")!r}, "w") as file:
    import os
    os.write(1, b"what a library in C prints")
"""
    subprocess.run(["bash", "-c", '"$0" -c "$1" >&-', sys.executable, code], check=True, timeout=300)
    assert (tmp_path / "file").read_text() == ""
