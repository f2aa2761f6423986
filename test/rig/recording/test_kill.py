# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recorders killed at random times: what is older than a second is there."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cdp_ident.bag.joint_state import typestore
from cdp_ident.rig.recording.facts import RecorderOptions
from cdp_ident.rig.recording.recorder import Recorder, Surroundings

RECORDERS = 20
"""In a batch, at once."""
LONGEST = 1.8
"""The last of a batch is killed this long after its start [s]."""

SCRIPT = textwrap.dedent(
    """
    import json, os, sys, time
    from pathlib import Path
    from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore
    from cdp_ident.rig.recording.recorder import Recorder, Surroundings
    from cdp_ident.rig.recording.facts import RecorderOptions

    def record(folder):
        recorder = Recorder(RecorderOptions(folder), Surroundings())
        number, ticked = 0, time.time_ns()
        while True:
            now = time.time_ns()
            raw = serialize_joint_state(["inner_joint", "outer_joint"], [1.0 + number % 2, float(number)], now)
            recorder.take("/joint_states", MESSAGE_TYPE, now, raw)
            if number == 0:
                recorder.start(now)
            if now - ticked >= 250_000_000:
                recorder.tick(now)
                ticked = now
            number += 1
            time.sleep(0.005)

    parent, batches, recorders = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    typestore()  # loads what is loaded once, before the clock runs
    for batch in range(batches):
        children = {}
        for number in range(recorders):
            folder = parent / f"{batch}_{number}"
            folder.mkdir()
            child = os.fork()
            if child == 0:
                record(folder)
            children[child] = str(folder)
        print(json.dumps(children), flush=True)
        for _ in children:
            os.wait()
    """
)


def read(folder):
    """Return the stamp and number of each message of the only bag in a folder, as a reader of others sees it."""
    (bag,) = folder.iterdir()
    with AnyReader([bag], default_typestore=typestore()) as reader:
        messages = [reader.deserialize(raw, connection.msgtype) for connection, _, raw in reader.messages()]
    return [
        (message.header.stamp.sec * 10**9 + message.header.stamp.nanosec, int(message.position[1]))
        for message in messages
    ]


@pytest.mark.parametrize("batches", [2, pytest.param(10, marks=pytest.mark.campaign)])
def test_killed_at_random_times_a_recorder_loses_nothing_older_than_a_second(tmp_path, batches):
    generator = np.random.default_rng(20)
    killed_ns = {}
    with subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(tmp_path), str(batches), str(RECORDERS)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parents[3],
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            began = time.monotonic()
            children = {int(child): Path(folder) for child, folder in json.loads(line).items()}
            delays = np.sort(generator.uniform(0.0, LONGEST, len(children)))
            for (child, folder), delay in zip(children.items(), delays, strict=True):
                time.sleep(max(0.0, began + delay - time.monotonic()))
                killed_ns[folder] = time.time_ns()
                os.kill(child, signal.SIGKILL)
    assert process.returncode == 0
    assert len(killed_ns) == batches * RECORDERS

    with_something = 0
    for folder, killed in killed_ns.items():
        Recorder(RecorderOptions(folder), Surroundings())  # the next start
        if not any(folder.iterdir()):
            continue
        (bag,) = folder.iterdir()
        if not (bag / "metadata.yaml").exists():
            # Killed before anything was written: there is nothing to complete.
            assert bag.stat().st_ctime_ns > killed - 1_000_000_000
            continue
        messages = read(folder)
        numbers = [number for _, number in messages]
        assert numbers == list(range(len(numbers)))
        assert messages[-1][0] > killed - 1_000_000_000
        with_something += 1
    assert with_something > 0.8 * len(killed_ns)
