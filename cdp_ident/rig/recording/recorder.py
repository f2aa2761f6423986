# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Records trials: arms, keeps the time before the release, and writes one bag for each trial."""

from collections import deque
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from cdp_ident.bag.device_messages import DIAGNOSTICS, read_statuses
from cdp_ident.bag.joint_state import MESSAGE_TYPE
from cdp_ident.bag.metadata import OFFERED_QOS_PROFILES, QosProfile
from cdp_ident.bag.writer import BagWriter, complete_bag, is_incomplete
from cdp_ident.errors import BagError, RigError
from cdp_ident.files import free_space
from cdp_ident.model.weights import Weight
from cdp_ident.outside_text import shown
from cdp_ident.rig.recording.detector import End, EndDetector, ReleaseDetector
from cdp_ident.rig.recording.facts import PositionReader, RecorderOptions, TrialFacts

FLUSH_NS = 250_000_000
"""Messages older than this survive a kill of the process [ns]; a bag has one chunk for each such time."""
_MOST_BYTES = 64_000_000
"""Of messages from before a release: a minute at 5 kHz has so many."""
_LONGEST_NAME = 200
"""Bytes; file systems take 255, and the time and endings follow."""
_LEAST_FREE = 50_000_000
"""Least free space on the disk [bytes]: ten minutes at 1 kHz need more."""

IDLE, ARMED, RECORDING = "idle", "armed", "recording"


@dataclass(frozen=True)
class Surroundings:
    """Callbacks of a recorder to its surroundings; without ROS they do nothing."""

    say: Callable[[str], None] = lambda _: None
    """Is given each thing that people should know …"""
    warn: Callable[[str], None] = lambda _: None
    """… and each that they should do something about."""
    on_state: Callable[[str], None] = lambda _: None
    """Is given each new state."""
    on_bag: Callable[[Path], None] = lambda _: None
    """Is given each finished bag."""
    drivers: Callable[[], Collection[str]] = lambda: ()
    """Returns the names of the nodes that publish the joint states: their diagnostics are those of the rig."""
    weights: Callable[[], tuple[Weight, ...]] = lambda: ()
    """Returns the weights that are clamped to the rods now."""
    offered: Callable[[str], Sequence[QosProfile]] = lambda _: OFFERED_QOS_PROFILES
    """Returns the quality of service that the publishers of a topic offer."""


class Message(NamedTuple):
    """A serialised message, as a recorder gets it."""

    topic: str
    message_type: str
    received_ns: int
    """Time of its receipt [ns since the epoch]."""
    raw: bytes


@dataclass
class _Trial:
    writer: BagWriter
    end: EndDetector
    facts: TrialFacts
    flushed_ns: int


class Recorder:
    """Records trials from serialised messages. All methods belong to one thread."""

    def __init__(self, options: RecorderOptions, surroundings: Surroundings) -> None:
        """Complete the bags that an earlier recorder left unfinished, and arm if so wished.

        Raises `RigError` where the folder cannot be written, or the bags' name is none.
        """
        if not _is_name(options.name):
            raise RigError(f"{shown(options.name)!r} is no name for bags: expected a name without folders")
        self.folder = options.folder.absolute()
        """Where bags go, each in a folder of its own."""
        self.state = IDLE
        self.problem = ""
        """What kept the last trial from being recorded; empty where nothing did."""
        self.last_bag: Path | None = None
        """Folder of the last finished bag."""
        self._options = options
        self._around = surroundings
        self._say, self._warn = surroundings.say, surroundings.warn
        self._check_folder()
        self._reader = PositionReader(options.joints)
        self._release = ReleaseDetector(options.limits)
        self._before: deque[Message] = deque()
        """The messages of the last seconds, some of which belong to the next trial too."""
        self._bytes_before = 0
        self._rig: dict[str, str] = {}
        self._trial: _Trial | None = None
        self._last_sample_ns: int | None = None
        self._last_stamp_ns = 0
        self._warned_of_joints = False
        self._complete_unfinished()
        surroundings.on_state(self.state)
        if options.rearm:
            self.arm()

    def hears_joint_states(self, now_ns: int) -> bool:
        """Return whether positions of the pendulum came lately."""
        return self._last_sample_ns is not None and now_ns - self._last_sample_ns <= self._options.limits.silence * 1e9

    def arm(self) -> str:
        """Wait for the release; return the state. Raises `RigError` while a trial is recorded, or where none can be."""
        if self.state == RECORDING:
            raise RigError("a trial is being recorded: stop it first")
        self._check_folder()
        self._set_state(ARMED)
        return self.state

    def start(self, now_ns: int) -> Path:
        """Record from now on (and the time before), release or not; return the bag's folder.

        Raises `RigError` while a trial is recorded, where no joint states come, or where the bag cannot be made.
        """
        if self.state == RECORDING:
            raise RigError("a trial is being recorded already")
        if not self.hears_joint_states(now_ns):
            raise RigError("no joint states come: is the driver running, and on the same topic?")
        self._check_folder()
        return self._begin(self._last_stamp_ns, now_ns, by_hand=True)

    def stop(self) -> Path | None:
        """End the trial, or the waiting for one; return the bag's folder where there is one.

        Raises `RigError` where there is nothing to stop, or the disk does not take the end of the bag.
        """
        if self.state == IDLE:
            raise RigError("nothing to stop: neither armed nor recording")
        if self._trial is None:
            self._set_state(IDLE)
            return None
        folder = self._trial.writer.folder
        self._finish(End.STOPPED)
        if self.state == ARMED:
            self._set_state(IDLE)
        return folder

    def close(self) -> None:
        """Complete the bag that is being recorded: the process ends."""
        if self._trial is not None:
            with suppress(RigError):  # it was said
                self._finish(End.STOPPED)

    def take(self, topic: str, message_type: str, received_ns: int, raw: bytes) -> None:
        """Take a serialised message that was received at `received_ns` [ns since the epoch].

        JointState and DiagnosticArray messages are evaluated, too; those of other types are only recorded.
        """
        message = Message(topic, message_type, received_ns, raw)
        self._write(message)
        self._keep(message)
        if message_type == MESSAGE_TYPE:
            self._take_sample(message)
        elif message_type == DIAGNOSTICS:
            self._take_diagnostics(raw)

    def tick(self, now_ns: int) -> None:
        """Flush what was written, so that it survives a kill; to be called several times a second."""
        if (trial := self._trial) is None:
            return
        try:
            trial.writer.flush()
            trial.flushed_ns = now_ns
        except BagError as error:
            self._fail(trial, error)
            return
        if not self.hears_joint_states(now_ns):
            with suppress(RigError):
                self._finish(End.SILENCE)

    def _keep(self, message: Message) -> None:
        """Keep a message for a trial that begins soon after it; drop those that are too old, or too many.

        Messages from after it go too: they were received before the clock was set back.
        """
        now, before = message.received_ns, self._before
        before.append(message)
        self._bytes_before += len(message.raw)
        oldest = now - self._options.pre_trigger * 1e9
        while before and (not oldest <= before[0].received_ns <= now or self._bytes_before > _MOST_BYTES):
            self._bytes_before -= len(before.popleft().raw)

    def _check_folder(self) -> None:
        """Make the folder if it is missing, and say so. Raises `RigError` where nothing can be written."""
        folder = self.folder
        try:
            missing = not folder.exists()
            folder.mkdir(parents=True, exist_ok=True)
            free = free_space(folder)
        except OSError as error:
            raise RigError(f"nothing can be recorded in {folder}: {error.strerror or error}") from error
        if free < _LEAST_FREE:
            raise RigError(f"nothing can be recorded in {folder}: only {free / 1e6:.0f} MB are free on its disk")
        if missing:
            self._say(f"made {folder}, which was not there")

    def _complete_unfinished(self) -> None:
        """Complete the bags that a recorder left unfinished, and say which, or why one is left as it is."""
        try:
            folders = sorted(path for path in self.folder.iterdir() if path.is_dir())
        except OSError as error:
            self._warn(f"left as it is: {self.folder} cannot be read: {error.strerror or error}")
            return
        for folder in folders:
            try:
                if is_incomplete(folder) and (salvaged := complete_bag(folder)):
                    self._say(f"completed a bag that was left unfinished: {salvaged}")
            except BagError as error:
                self._warn(f"left as it is: {error}")

    def _new_bag(self, now_ns: int) -> BagWriter:
        """Begin a bag, whichever other recorders begin theirs in the same second; raises `BagError` where it cannot."""
        when = datetime.fromtimestamp(now_ns * 1e-9).astimezone().strftime("%Y%m%d_%H%M%S")
        name = f"{self._options.name}_{when}"
        folder, number = self.folder / name, 1
        while True:
            try:
                return BagWriter(folder)
            except BagError as error:
                if not isinstance(error.__cause__, FileExistsError):
                    raise
            number += 1
            folder = self.folder / f"{name}_{number}"

    def _take_sample(self, message: Message) -> None:
        position = self._reader.read(message.raw)
        if position is None:
            if not self._warned_of_joints:
                self._warned_of_joints = True
                joints = self._options.joints
                self._warn(
                    f"a message on {message.topic} has no positions of {joints.inner_joint} and {joints.outer_joint}: "
                    "it is recorded, but release and rest are not detected in it; set the parameters inner_joint and "
                    "outer_joint"
                )
            return
        self._last_sample_ns, self._last_stamp_ns = message.received_ns, position.stamp_ns
        released = self._release.update(position.stamp_ns, position.inner, position.outer)
        if self._trial is not None:
            self._trial.facts.take(position)
            end = self._trial.end.update(position.stamp_ns, position.inner, position.outer)
            if released and not self._trial.facts.started_by_hand:
                end = End.CAUGHT
            if end is not None:
                with suppress(RigError):  # it was said
                    self._finish(end)
        if released and self.state == ARMED:
            with suppress(RigError):
                self._begin(position.stamp_ns, message.received_ns, by_hand=False)

    def _take_diagnostics(self, raw: bytes) -> None:
        drivers = self._around.drivers()
        for status in read_statuses(raw):
            if status.name in drivers:
                description = {"name": status.name, "hardware_id": status.hardware_id, "status": status.message}
                self._rig = description | dict(status.values)

    def _begin(self, stamp_ns: int, now_ns: int, by_hand: bool) -> Path:
        options = self._options
        try:
            writer = self._new_bag(now_ns)
        except BagError as error:
            self._fail_with(str(error))
            raise RigError(str(error)) from error
        facts = TrialFacts(options, stamp_ns, by_hand, weights=self._around.weights())
        self._trial = _Trial(writer, EndDetector(options.limits, stamp_ns, not by_hand), facts, now_ns)
        self.problem = ""
        for message in tuple(self._before):
            self._write(message)
            if message.message_type == MESSAGE_TYPE and (position := self._reader.read(message.raw)):
                facts.take(position)
        self.tick(now_ns)
        if self._trial is None:  # the disk did not even take what was kept from before
            raise RigError(self.problem)
        self._set_state(RECORDING)
        self._say(f"{'started' if by_hand else 'released'}: recording {writer.folder}")
        return writer.folder

    def _write(self, message: Message) -> None:
        """Write a message where a trial is recorded."""
        if (trial := self._trial) is None:
            return
        try:
            if message.topic not in trial.writer.topics:
                offered = self._around.offered(message.topic)
                trial.writer.add_topic(message.topic, message.message_type, offered=offered)
            trial.writer.write(message.topic, message.message_type, message.received_ns, message.raw)
            if message.received_ns - trial.flushed_ns >= FLUSH_NS:
                trial.writer.flush()
                trial.flushed_ns = message.received_ns
        except BagError as error:
            self._fail(trial, error)

    def _finish(self, end: End) -> None:
        trial, self._trial = self._trial, None
        assert trial is not None
        trial.facts.rig = self._rig
        try:
            trial.writer.close(trial.facts.as_metadata(end))
        except BagError as error:
            self._fail_with(f"{error}; what is on the disk is completed at the recorder's next start")
            raise RigError(str(error)) from error
        folder = trial.writer.folder
        self._say(f"{folder}: {end.value} after {trial.facts.duration:.1f} s, {len(trial.facts.stamps)} samples")
        for warning in trial.facts.warnings():
            self._warn(f"{folder}: {warning}")
        self._set_state(IDLE)
        self.last_bag = folder.absolute()
        self._around.on_bag(self.last_bag)
        if self._options.rearm:
            try:
                self.arm()
            except RigError as error:
                self._fail_with(str(error))

    def _fail(self, trial: _Trial, error: BagError) -> None:
        """Give up the trial whose bag cannot be written; what is on the disk stays there."""
        self._trial = None
        self._fail_with(f"{error}; recording stops, what is on the disk is kept")
        try:
            trial.writer.close(trial.facts.as_metadata(End.FAILED))
        except BagError:
            if trial.writer.folder.is_dir():
                self._warn(f"{trial.writer.folder} is completed at the recorder's next start")

    def _fail_with(self, problem: str) -> None:
        self.problem = problem
        self._warn(problem)
        self._set_state(IDLE)

    def _set_state(self, state: str) -> None:
        if state != self.state:
            self.state = state
            self._around.on_state(state)


def _is_name(name: str) -> bool:
    """Return whether a text can begin the names of folders and does not lead to another folder."""
    return name.isprintable() and 0 < len(name.encode()) <= _LONGEST_NAME and name[0] != "." and Path(name).name == name
