"""The example files are what the nodes declare."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

FILE = Path(__file__).parents[2] / "config" / "rig.yaml"
Start = Callable[..., Any]


@pytest.mark.parametrize("node", ["driver", "recorder"])
def test_every_key_of_the_example_is_a_parameter(listener: Any, start: Start, tmp_path: Path, node: str) -> None:
    overrides = {"driver": ["-p", f"port:={tmp_path / 'tty'}"], "recorder": ["-p", f"folder:={tmp_path / 'trials'}"]}
    process = start(node, "--ros-args", "--params-file", str(FILE), *overrides[node])
    name = "baud" if node == "driver" else "longest"
    changed, reason = listener.set_parameter(
        f"/{node}", name, yaml.safe_load(FILE.read_text())[node]["ros__parameters"][name]
    )
    assert not changed
    assert "restart" in reason
    assert process.popen.poll() is None
