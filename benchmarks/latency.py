# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How late a sample is published, beside plain pyserial, and what it costs beside a minimal decode and publish.

`python -m benchmarks latency` takes a minute: frames are written into a pseudo-terminal, one each period.
"""

import itertools
import os
import struct
import subprocess
import sys
import tempfile
import time
import tty
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import rclpy
import serial
from cobs import cobs
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState, TimeReference

from cdp_ident.nodes.driver import Driver
from cdp_ident.rig.protocol import BinaryCodec, Hello, Sample, checksum
from cdp_ident.ros.parameters import Parameters

SECONDS = 10.0
WRITER = """
import os, sys, time
from benchmarks.latency import CODEC, HELLO, Sample
device, rate, count = int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3])
began, number, greeted = time.monotonic(), 0, -1
while number < count:
    time.sleep(max(0.0, began + number / rate - time.monotonic()))
    number = max(number, int((time.monotonic() - began) * rate))  # what was missed is not made up for, as by a rig
    greeting, greeted = HELLO if number // int(rate) != greeted else b"", number // int(rate)
    os.write(device, greeting + CODEC.encode(Sample(number, time.monotonic_ns() // 1000 % 2**32, 0, 0, 0)))
    number += 1
"""
CODEC = BinaryCodec()
HELLO = CODEC.encode(Hello(5000, 8000, 8000, "latency"))


@contextmanager
def cable(folder: Path) -> Iterator[tuple[Path, int]]:
    """Give a port and its device's end."""
    device, computer = os.openpty()
    tty.setraw(computer)
    link = folder / "tty"
    link.symlink_to(os.ttyname(computer))
    yield link, device
    link.unlink()
    os.close(device)
    os.close(computer)


def write(device: int, rate: float) -> "subprocess.Popen[bytes]":
    """Begin to write frames."""
    words = [sys.executable, "-c", WRITER, str(device), str(rate), str(int(SECONDS * rate))]
    return subprocess.Popen(words, pass_fds=[device])


def late(time_us: int) -> float:
    """Return how long ago a time of the device was [ms]."""
    return (time.monotonic_ns() // 1000 - time_us) % 2**32 * 1e-3


def by_pyserial(port: Path, device: int, rate: float) -> list[float]:
    """Return how late samples are that are read from the port and decoded [ms]."""
    found, rest = [], b""
    with serial.Serial(str(port), timeout=0.1) as connection:
        writer = write(device, rate)
        while writer.poll() is None:
            *frames, rest = (rest + connection.read(max(1, connection.in_waiting))).split(b"\0")
            for record in map(CODEC.decode, frames):
                if isinstance(record, Sample):
                    found.append(late(record.time_us))
    return found


def by_driver(port: Path, device: int, rate: float) -> tuple[list[float], float]:
    """Return how late samples are when a subscriber of the driver hears them [ms], and CPU time of one [us]."""
    node, found = rclpy.create_node("latency"), []

    def take(message: Any) -> None:
        found.append(late(message.time_ref.sec * 10**6 + message.time_ref.nanosec // 1000))

    def cpu() -> float:
        user, system = Path(f"/proc/{driver.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    node.create_subscription(TimeReference, "time_reference", take, QoSProfile(depth=2000))
    words = ("driver", "--ros-args", "-p", f"port:={port}", "-p", f"zero_file:={port.parent / 'zero.yaml'}")
    driver = subprocess.Popen([sys.executable, "-m", "cdp_ident", *words], stderr=subprocess.DEVNULL)
    time.sleep(5.0)
    writer, began, before = write(device, rate), time.monotonic(), 0.0
    while writer.poll() is None:
        rclpy.spin_once(node, timeout_sec=0.1)
        if not before and time.monotonic() - began > 3.0:  # samples before it have waited for the clock
            found.clear()
            before = cpu()
    used = cpu() - before
    driver.terminate()
    driver.wait()
    node.destroy_node()
    return found, used / len(found) * 1e6


def minimal(node: Any) -> Callable[[bytes], None]:
    """Return what a minimal driver does with a frame: decode it, check it, publish both messages."""
    states, times = node.create_publisher(JointState, "a", 2000), node.create_publisher(TimeReference, "b", 2000)
    state, reference = JointState(name=["cart_joint", "inner_joint", "outer_joint"]), TimeReference()
    fields = struct.Struct("<BBIIiiiB")

    def take(frame: bytes) -> None:
        data = cobs.decode(frame[:-1])
        if checksum(data[:-2]) != int.from_bytes(data[-2:], "little"):
            return
        _, _, _, time_us, cart, inner, outer, _ = fields.unpack(data[:-2])
        now = node.get_clock().now().nanoseconds
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(now, 10**9)
        state.position = array("d", (cart * 1e-5, inner * 8e-4, outer * 8e-4))
        reference.header.stamp = state.header.stamp
        reference.time_ref.sec, reference.time_ref.nanosec = divmod(time_us * 1000, 10**9)
        states.publish(state)
        times.publish(reference)

    return take


def share() -> tuple[float, float]:
    """Return the CPU time of a sample [us]: of the driver, and of a minimal one; neither has a subscriber."""
    words = ["--ros-args", "-p", "port:=/nowhere", "-p", "zero_file:=/nowhere/zero.yaml"]
    node = rclpy.create_node("driver", cli_args=words)
    driver, plain = Driver(node, Parameters(node, words)), minimal(node)
    frames = [CODEC.encode(Sample(number, number * 5000, 0, number % 800, number % 300)) for number in range(24_000)]
    arrivals = itertools.count(10**18, 5_000_000)
    driver._clock = SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=next(arrivals)))
    driver._take(HELLO)
    found: list[list[float]] = [[], []]
    for first in range(0, len(frames), 500):
        for times, take in zip(found, (driver._take, plain), strict=True):
            began = time.thread_time()
            for frame in frames[first : first + 500]:
                take(frame)
            times.append((time.thread_time() - began) / 500 * 1e6)
    driver.close()
    node.destroy_node()
    return min(found[0]), min(found[1])


def main() -> None:
    """Measure and print."""
    rclpy.init()
    with tempfile.TemporaryDirectory() as name, suppress(KeyboardInterrupt):
        for rate in (200.0, 1000.0):
            with cable(Path(name)) as (port, device):
                plain = by_pyserial(port, device, rate)
            with cable(Path(name)) as (port, device):
                driven, cpu = by_driver(port, device, rate)
            for who, times in (("pyserial", plain), ("driver", driven)):
                middle, most = np.percentile(times, [50, 95])
                print(f"{rate:5g} Hz, {who}: {middle:.2f} ms at the median, {most:.2f} ms at 95 %")
            print(f"{rate:5g} Hz, driver: {cpu:.0f} us of CPU a sample")
    mine, least = share()
    print(f"decode and publish: driver {mine:.0f} us, minimal {least:.0f} us: {mine / least:.2f} times")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
