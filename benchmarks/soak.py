# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""1 kHz from the serial port to the bag: rate, jitter, loss, CPU and memory of each node.

`python -m benchmarks soak` takes ten minutes, `python -m benchmarks.soak SECONDS [RIGS]` as long as asked.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import rclpy
from rich.console import Console
from rich.table import Table
from std_srvs.srv import Trigger

from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.bag.reader import read_joint_states

RATE = 1000.0
RIG = f"""
rate: {RATE}
script: [wait: 2, hold: {{theta1: 1.5, theta2: 1.8, within: 1}}, wait: 1, let_go, wait: 20]
repeat: 10000
"""
_TICKS = os.sysconf("SC_CLK_TCK")
_PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass
class Usage:
    """What one process has used, read once a second."""

    process: subprocess.Popen[bytes]
    at: list[float] = field(default_factory=list)
    """When it was read [s]."""
    cpu: list[float] = field(default_factory=list)
    """CPU time since its start [s]."""
    memory: list[float] = field(default_factory=list)
    """Resident memory [MB]."""

    def read(self) -> None:
        """Read both now."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        self.at.append(time.monotonic())
        self.cpu.append((int(fields[11]) + int(fields[12])) / _TICKS)
        self.memory.append(int(fields[21]) * _PAGE / 1e6)


def call(service: str) -> str:
    """Call a Trigger service until it succeeds; return its message."""
    node, answer = rclpy.create_node("soak"), "no answer"
    try:
        client = node.create_client(Trigger, service)
        for _ in range(120):  # the emulator may compile first
            if client.wait_for_service(timeout_sec=2.0):
                future = client.call_async(Trigger.Request())
                rclpy.spin_until_future_complete(node, future, timeout_sec=120.0)
                if future.done():
                    answer = str(future.result().message)
                    if future.result().success:
                        return answer
            time.sleep(1.0)
    finally:
        node.destroy_node()
    raise RuntimeError(f"{service} did not succeed: {answer}")


@contextmanager
def rig(folder: Path, namespace: str) -> Iterator[dict[str, Usage]]:
    """Run emulator, driver and recorder in a folder."""
    (folder / "rig.yaml").write_text(RIG)
    port, here = str(folder / "tty"), ["--ros-args", "-r", f"__ns:={namespace}"]
    commands = {
        "emulator": ["--link", port, "--rig", str(folder / "rig.yaml"), "--delay", "0.005", *here],
        "driver": [*here, "-p", f"port:={port}", "-p", f"zero_file:={folder / 'zero.yaml'}"],
        # Nothing ends the recording but ~/stop: no rest, no gap.
        "recorder": [
            *here,
            *("-p", f"folder:={folder / 'trials'}", "-p", "longest:=86400.0"),
            *("-p", "away_limit:=0.0", "-p", "silence:=60.0"),
        ],
    }
    processes = {
        name: subprocess.Popen([sys.executable, "-m", "cdp_ident", name, *arguments])
        for name, arguments in commands.items()
    }
    try:
        yield {name: Usage(process) for name, process in processes.items()}
    finally:
        for process in processes.values():
            process.terminate()
        for process in processes.values():
            process.wait(timeout=300.0)  # many rigs on few cores take long


def main(seconds: float = 600.0, rigs: int = 1) -> None:
    """Run the soak and print what it showed."""
    names = [f"/rig{number + 1}" for number in range(rigs)]
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        nodes = {}
        for name in names:
            (Path(folder) / name[1:]).mkdir()
            nodes[name] = stack.enter_context(rig(Path(folder, name[1:]), name))
        rclpy.init()
        bags = [Path(call(f"{name}/recorder/start")) for name in names]
        began = time.monotonic()
        while time.monotonic() - began < seconds:
            for usage in (usage for of_rig in nodes.values() for usage in of_rig.values()):
                usage.read()
            time.sleep(1.0)
        for name in names:
            call(f"{name}/recorder/stop")
        rclpy.shutdown()
        for name, bag in zip(names, bags, strict=True):
            _show(name, nodes[name], read_joint_states(bag, f"{name}/joint_states"))


def _show(name: str, nodes: dict[str, Usage], recording: JointRecording) -> None:
    steps = np.diff(recording.stamps) * 1e-9 * RATE
    lost = int(np.sum(np.round(steps[steps > 1.5]) - 1))
    lasted = (recording.stamps[-1] - recording.stamps[0]) * 1e-9
    table = Table(title=f"{name}: {len(recording.stamps)} samples in {lasted:.1f} s")
    for heading in ("node", "CPU of one core", "memory after 1/10", "memory at the end"):
        table.add_column(heading)
    for node, usage in nodes.items():
        share = (usage.cpu[-1] - usage.cpu[0]) / (usage.at[-1] - usage.at[0])
        early, late = usage.memory[len(usage.memory) // 10], usage.memory[-1]
        table.add_row(node, f"{share:.1%}", f"{early:.1f} MB", f"{late:.1f} MB")
    console = Console()
    console.print(table)
    even = steps[steps < 1.5]
    console.print(f"rate {len(steps) / lasted:.2f} Hz · lost {lost}")
    console.print(
        f"jitter of stamps: standard deviation {np.std(even) / RATE * 1e6:.2f} us, "
        f"at most {np.max(np.abs(even - 1)) / RATE * 1e6:.2f} us"
    )


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 600.0, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
