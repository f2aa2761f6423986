# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nodes do not outlive the block that they run in."""

import os
import signal
import subprocess
import sys

import pytest

from cdp_ident.demo.nodes import Nodes
from cdp_ident.errors import CdpIdentError


def test_a_node_that_ends_is_told_of_with_its_last_words(tmp_path):
    with Nodes(tmp_path) as nodes:
        nodes.start("emulator")
        with pytest.raises(CdpIdentError, match=r"the node emulator ended with exit code 2: emulator: error: .*--link"):
            nodes.wait_for("an end", lambda: False)


def test_a_signal_is_noticed_at_the_next_check_and_then_belongs_to_its_owner_again(tmp_path):
    before = signal.getsignal(signal.SIGTERM)
    with Nodes(tmp_path) as nodes:
        os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt):
            nodes.check()
    assert signal.getsignal(signal.SIGTERM) is before


def test_signals_that_are_ignored_stay_so(tmp_path):
    code = (
        "import os, signal, sys; from pathlib import Path; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
        "from cdp_ident.demo.nodes import Nodes\n"
        "with Nodes(Path(sys.argv[1])) as nodes: os.kill(os.getpid(), signal.SIGHUP); nodes.check()"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False, timeout=60)
    assert done.returncode == 0
