# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every executable answers its command line in the same way, and goes on wherever its output goes."""

import importlib
import math
import os
import subprocess
import sys

import pytest

from cdp_ident.command_line import ArgumentParser, entry_point, split_arguments, within
from cdp_ident.executables import EXECUTABLES

MAINS = [pytest.param(importlib.import_module(module).main, id=name) for name, module in EXECUTABLES.items()]


@pytest.mark.parametrize("main", MAINS)
def test_an_unknown_option_is_one_line_and_exit_code_2(main, capsys):
    assert main(["--no-such-option"]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert "--help tells more" in err


@pytest.mark.parametrize("main", MAINS)
def test_help_is_printed_and_exits_0(main, capsys):
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith("usage: ")


@pytest.mark.parametrize(
    ("arguments", "own", "of_ros"),
    [
        ([], [], []),
        (["--bag", "one"], ["--bag", "one"], []),
        (["--bag", "\udcff", "--ros-args", "-p", "a:=1"], ["--bag", "\udcff"], ["-p", "a:=1"]),
        (["--ros-args", "-p", "a:=1", "--", "--once"], ["--once"], ["-p", "a:=1"]),
        (["--ros-args", "-p", "a:=1", "--ros-args", "-p", "b:=2"], [], ["-p", "a:=1", "-p", "b:=2"]),
        (["one", "--", "two"], ["one", "--", "two"], []),
    ],
)
def test_ros_is_given_what_stands_behind_its_mark(arguments, own, of_ros):
    assert split_arguments(arguments) == (own, of_ros)
    parser = ArgumentParser("probe", "A probe.")
    parser.add_argument("words", nargs="*")
    parser.add_argument("--bag")
    parser.add_argument("--once", action="store_true")
    assert parser.parse_args(arguments) == parser.parse_args(own)


@pytest.mark.parametrize("main", MAINS)
def test_what_a_launch_file_s_node_appends_is_taken(main, capsys):
    appended = ["--ros-args", "-r", "__node:=mine", "--params-file", "/dev/null"]
    assert main(["--no-such-option", *appended]) == 2
    assert not {"--ros-args", "__node:=mine"} & set(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (RuntimeError("can't start new thread"), "can't start new thread"),
        (ValueError("embedded null byte"), "embedded null byte"),
        (MemoryError(), "the memory does not suffice"),
        (MemoryError("Unable to allocate 8 GiB"), "Unable to allocate 8 GiB"),
        (OSError(24, "Too many open files", "a.yaml"), "a.yaml: Too many open files"),
    ],
)
def test_what_the_system_refuses_is_one_line_and_exit_code_2(error, words, capsys):
    def body(_arguments):
        raise error

    assert entry_point(body)([]) == 2
    assert capsys.readouterr().err.endswith(f": error: {words}\n")


def test_a_number_within_limits_has_no_sign_that_nobody_sees():
    assert math.copysign(1.0, within(0.0, 1.0)("-0")) == 1.0


def test_an_error_of_the_program_is_none_of_the_system():
    def body(_arguments):
        raise RuntimeError("a mistake")

    with pytest.raises(RuntimeError, match="a mistake"):
        entry_point(body)([])


PRINTS = """
import sys
from cdp_ident.command_line import entry_point, make_tolerant
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
from cdp_ident.command_line import make_tolerant
make_tolerant()
with open({str(tmp_path / "file")!r}, "w") as file:
    import os
    os.write(1, b"what a library in C prints")
"""
    subprocess.run(["bash", "-c", '"$0" -c "$1" >&-', sys.executable, code], check=True, timeout=300)
    assert (tmp_path / "file").read_text() == ""
