# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nodes as processes that do not outlive the program that started them."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any

from cdp_ident.errors import CdpIdentError

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_PATIENCE = 15.0
"""Longest wait for a node to end after it was asked to [s]."""


class Nodes:
    """Runs nodes of this package while a `with` block lasts; at its end, whatever the reason, all are stopped.

    Inside the block a signal to end (Ctrl-C, SIGTERM, SIGHUP) is noticed at the next `check`, which raises
    `KeyboardInterrupt`; so nothing is interrupted half-way, neither a start nor the stopping.
    """

    def __init__(self, logs: Path) -> None:
        """What the nodes print goes to a file each in the folder `logs`."""
        self._logs = logs
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._handlers: dict[signal.Signals, Any] = {}
        self._asked_to_end = False

    def __enter__(self) -> "Nodes":
        self._logs.mkdir(parents=True, exist_ok=True)
        for number in _SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._handlers[number] = signal.signal(number, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            for name in reversed(tuple(self._running)):
                with suppress(CdpIdentError):
                    self.stop(name)
        finally:
            for number, handler in self._handlers.items():
                signal.signal(number, handler)

    def start(self, name: str, *arguments: str, logged: bool = True) -> None:
        """Start a node; one that is not `logged` prints where this program does."""
        output = self._log(name).open("wb") if logged else None
        try:
            # A session of its own: Ctrl-C is for this program, which then stops the nodes in order.
            self._running[name] = subprocess.Popen(
                [sys.executable, "-m", "cdp_ident", name, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                start_new_session=True,
            )
        finally:
            if output:
                output.close()

    def check(self) -> None:
        """Raise `CdpIdentError` where a node has ended by itself, `KeyboardInterrupt` where the program is to end."""
        if self._asked_to_end:
            raise KeyboardInterrupt
        for name, process in self._running.items():
            if process.poll() is not None:
                raise self._failure(name, process.returncode)

    def stop(self, name: str) -> None:
        """Ask a node to end and wait for it. Raises `CdpIdentError` where it did not end well."""
        process = self._running.pop(name)
        process.terminate()
        try:
            code = process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        if code != 0:
            raise self._failure(name, code)

    def _note(self, _number: int, _frame: FrameType | None) -> None:
        self._asked_to_end = True

    def _log(self, name: str) -> Path:
        return self._logs / f"{name}.log"

    def _failure(self, name: str, code: int) -> CdpIdentError:
        sentence = f"the node {name} ended with exit code {code}"
        log = self._log(name)
        if not log.exists():
            return CdpIdentError(f"{sentence}; what it said stands above")
        said = log.read_text(errors="replace").splitlines()
        return CdpIdentError(f"{sentence}: {said[-1] if said else 'it said nothing'} (all of it: {log})")


def own_domain() -> None:
    """Let this program and the nodes that it starts find only each other, not a rig that runs on this network."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(os.getpid() % 100 + 1)
