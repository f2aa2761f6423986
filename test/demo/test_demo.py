# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The demonstration does what it says, and leaves no process behind however it ends."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cdp_ident.demo.demo import main
from cdp_ident.demo.recording import RIG
from cdp_ident.report.folder import FIGURES, FILES

pytestmark = pytest.mark.waits

ROOT = Path(__file__).parents[2]
PATIENCE = 300.0


def start(out, *options):
    command = [sys.executable, "-m", "cdp_ident", "demo", "--out", str(out), *options]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def processes_of(out):
    """Return the process of each node that works in this folder, by the node's name."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = entry.read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if words[1:3] == ["-m", "cdp_ident"] and words[3] != "demo" and any(str(out) in word for word in words):
            found[words[3]] = int(entry.parent.name)
    return found


def wait_for_nodes(out, demo):
    deadline = time.monotonic() + PATIENCE
    while set(processes_of(out)) < {"driver", "recorder", "emulator"}:
        assert demo.poll() is None, demo.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return processes_of(out)


def test_it_records_identifies_asks_the_node_and_names_what_is_hidden(tmp_path):
    rig = tmp_path / "rig.yaml"
    *two_swings, _third = re.split(r"(?=  - hold)", RIG.read_text())  # quicker
    rig.write_text("".join(two_swings).replace("wait: 12.5", "wait: 6.5").replace("rate: 200.0", "rate: 100.0"))
    demo = start(tmp_path / "out", "--rig", str(rig))
    said, errors = demo.communicate(timeout=900)
    assert demo.returncode == 0, errors
    assert "Dry friction in the outer joint" in said
    errors = [float(error) for error in re.search(r"E\(Z\) \[rad²\] +(.+)", said)[1].split()]
    assert errors == sorted(errors, reverse=True)
    assert len(errors) == 10
    asked = re.search(r"param get /identify effects.coulomb_friction.outer.torque +(\S+)", said)
    assert 0.001 < float(asked[1]) < 0.003
    hidden, found = re.search(r"coulomb friction, outer: torque / A22 +(\S+) +(\S+)", said).groups()
    assert float(found) == pytest.approx(float(hidden), rel=0.02)
    assert {path.name for path in (tmp_path / "out/report").iterdir()} == {*FILES} - {FIGURES}
    assert str(tmp_path / "out/report/report.html") in said.split()
    assert len(list((tmp_path / "out/trials").iterdir())) == 2
    assert not processes_of(tmp_path / "out")


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.campaign)])
def test_interrupted_it_stops_all_nodes(tmp_path, number):
    demo = start(tmp_path / "out")
    wait_for_nodes(tmp_path / "out", demo)
    demo.send_signal(number)
    demo.send_signal(number)
    assert demo.wait(PATIENCE) == 130
    assert demo.stderr.read() == "demo: interrupted\n"
    assert not processes_of(tmp_path / "out")


def test_where_a_node_ends_it_says_so_in_one_line_and_stops_the_others(tmp_path):
    demo = start(tmp_path / "out")
    os.kill(wait_for_nodes(tmp_path / "out", demo)["driver"], signal.SIGKILL)
    assert demo.wait(PATIENCE) == 2
    assert re.fullmatch(r"demo: error: the node driver ended with exit code -9.*\n", demo.stderr.read())
    assert not processes_of(tmp_path / "out")


def test_a_folder_that_is_there_is_left_alone(tmp_path, capsys):
    assert main(["--out", str(tmp_path)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_rig_that_swings_only_once_is_refused_before_anything_is_made(tmp_path, capsys):
    (tmp_path / "rig.yaml").write_text("{script: [wait: 1, let_go, wait: 5]}")
    assert main(["--rig", str(tmp_path / "rig.yaml"), "--out", str(tmp_path / "out")]) == 2
    assert "twice or more" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
