"""The demonstration does what it says."""

import re
import subprocess
import sys
from pathlib import Path

from cdp_ident.commands.demo import main

ROOT = Path(__file__).parents[2]


def test_it_identifies_asks_the_node_and_leaves_a_report(tmp_path):
    command = [sys.executable, "-m", "cdp_ident", "demo", "--out", str(tmp_path / "out")]
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "Error, measured against simulated" in done.stdout
    assert re.search(r"param get /identify groups.c2_over_A22 +0.01009", done.stdout)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["fitted.yaml", "report.json"]


def test_without_the_example_bags_it_says_so(tmp_path, capsys):
    assert main(["--bags", str(tmp_path)]) == 2
    assert "does not hold the example bags" in capsys.readouterr().err


def test_a_node_that_cannot_identify_is_told_of(tmp_path):
    for name in ("swing_wide", "swing_folded", "swing_check"):
        (tmp_path / name).mkdir()
    command = [sys.executable, "-m", "cdp_ident", "demo", "--bags", str(tmp_path), "--out", str(tmp_path / "out")]
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True, timeout=300)
    assert done.returncode == 2
    assert "ended with exit code 2" in done.stderr
