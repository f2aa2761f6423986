# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What docs/reference/simulator.md shows is so."""

import re
import subprocess
import sys
from pathlib import Path

from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.model.parameters import NOMINAL

ROOT = Path(__file__).parents[2]


def test_the_library_s_example_runs(tmp_path):
    (tmp_path / "fitted.yaml").write_text(parameter_file(NOMINAL))
    found = re.search(r"```python\n(.*?)```", (ROOT / "docs/reference/simulator.md").read_text(), re.DOTALL)
    assert found
    code = found[1].replace("identification/swing_wide", str(tmp_path))
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False, capture_output=True, text=True)
    assert 0.0 < float(done.stdout) < 100.0, done.stderr
