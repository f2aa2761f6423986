# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What tests of commands share."""

import pytest


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
