# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What tests of commands share."""

import pytest

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.commands.import_csv import main
from scenarios.tables import text_of


@pytest.fixture
def refused(capsys):
    """Return a function that returns what a command says that refuses its arguments: one line, and nothing else."""

    def run(main, arguments):
        capsys.readouterr()
        assert main([str(argument) for argument in arguments]) == 2
        out, err = capsys.readouterr()
        assert not out
        assert err.count("\n") == 1
        return err

    return run


@pytest.fixture
def run(tmp_path):
    """Import a text, or columns of numbers, with options; returns the exit code."""

    def imported(content, *options, **how):
        text = content if isinstance(content, str) else text_of(content, **how)
        (tmp_path / "log.csv").write_text(text, encoding="utf-8")
        return main([str(tmp_path / "log.csv"), "--out", str(tmp_path / "bag"), *options])

    return imported


@pytest.fixture
def convert(run, tmp_path):
    """Import what is taken; returns the joints' positions, the stamps, and the whole recording."""

    def imported(content, *options, **how):
        assert run(content, *options, **how) == 0
        recording = read_joint_states(tmp_path / "bag", "joint_states")
        return recording.positions, recording.stamps, recording

    return imported


@pytest.fixture
def refuse(run, tmp_path, capsys):
    """Import what is not taken; returns the error."""

    def imported(content, *options, **how):
        assert run(content, *options, **how) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert not (tmp_path / "bag").exists()
        return error

    return imported
