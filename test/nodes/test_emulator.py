# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The emulator's command line."""

import pytest

from cdp_ident.nodes.emulator import main


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rig", "nowhere.yaml"], "nowhere.yaml cannot be read"),
        (["--flips", "2"], "not a number from 0 to 1"),
        (["--speed", "0"], "not a number from 0.001 to 1000"),
        (["--seed", "-1"], "-1 is not a number from 0 to 4294967295"),
        (["--first-count", "2147483648"], "2147483648 is not a number from -2147483648 to 2147483647"),
        ([], "something else is there"),
    ],
)
def test_wrong_arguments_are_told_with_exit_code_2(tmp_path, arguments, words, capfd):
    (tmp_path / "tty").write_text("mine")
    assert main(["--link", str(tmp_path / "tty"), *arguments]) == 2
    (line,) = [line for line in capfd.readouterr().err.splitlines() if not line.startswith("[INFO]")]
    assert line.startswith("emulator: error: ")
    assert words in line
    assert (tmp_path / "tty").read_text() == "mine"


def test_a_port_that_cannot_come_back_ends_it_in_one_line(start_emulator, tmp_path):
    (tmp_path / "mine").write_text("mine")
    emulator = start_emulator("--unplug-at", "0.1", "--unplugged-for", "0.1", "--replug-as", str(tmp_path / "mine"))
    assert emulator.exit_code() == 2
    assert "something else is there" in emulator.said
    assert "Traceback" not in emulator.said
    assert (tmp_path / "mine").read_text() == "mine"


@pytest.mark.campaign  # it compiles
def test_ctrl_c_while_it_compiles_is_not_lost(start, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    emulator = start("emulator", "--link", str(tmp_path / "rig"), "--ros-args", "--log-level", "debug")
    emulator.wait_until_it_says("emulator")  # the node is made
    assert not (tmp_path / "rig").exists()
    assert emulator.end() == 0
    assert "Traceback" not in emulator.said
    assert not (tmp_path / "rig").is_symlink()
