"""Reading the joint positions of any rosbag2 bag."""

from __future__ import annotations

import shutil
import struct
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt
import zstandard

from cdp_ident.bag.device_messages import DeviceMessages, DeviceTime
from cdp_ident.bag.joint_state import HEAD_OFFSET, MESSAGE_TYPE, NANOSECONDS, STAMP_OFFSET, Layout, parse_layout
from cdp_ident.bag.limits import LARGEST_WINDOW, Budget
from cdp_ident.bag.mcap_scan import McapScan
from cdp_ident.bag.message_compression import plain_message
from cdp_ident.bag.sqlite_scan import sqlite_messages, sqlite_topics
from cdp_ident.errors import BagError
from cdp_ident.outside_text import shown
from cdp_ident.regular_file import open_regular

_MESSAGE_TYPES = (MESSAGE_TYPE, "sensor_msgs/JointState")
_SQLITE_MAGIC = b"SQLite format 3\0"
_BLOCK = 1 << 20
_LEFT_FREE = 100_000_000
"""So much of the disk with the temporary files is left to others [bytes]."""
_LAYOUTS_AT_HAND = 8
_MOST_JOINTS = 256
_LONGEST_HEAD = 1 << 14
"""Bytes of the frame and joint names of a message; 256 joints with names of 60 letters have no more."""
_MOST_ROWS = 8_000_000
"""Two hours at 1 kHz."""
_MOST_VALUES = 1 << 25
"""Positions of all joints in all rows: an hour of a robot with eight joints at 1 kHz."""
_MOST_LAYOUTS = 1 << 14
"""Ways in which messages begin; writers have one or a few."""


@dataclass(frozen=True)
class JointRecording:
    """The joint positions that a bag holds on one topic, in the order of their receipt."""

    name: str
    """What people call the bag."""
    topic: str
    joints: tuple[str, ...]
    """Every joint that is named in any message."""
    stamps: npt.NDArray[np.int64]
    """(n,) time of the measurement [ns since the epoch]; see `notes` for where it was taken from."""
    positions: npt.NDArray[np.float64]
    """(n, joints) positions as recorded [rad or m]; NaN where a message does not name the joint."""
    notes: tuple[str, ...]
    """What was dropped or noticed while reading, in words, with numbers."""
    device: DeviceTime | None = None
    """The device's own time of the samples, where the bag has it."""


def read_joint_states(bag: Path, topic: str) -> JointRecording:
    """Read the JointState messages on a topic of a rosbag2 bag; the bag itself is not changed.

    `bag` is a folder or one .mcap or .db3 file, also compressed as a whole (.zstd) or by message. `metadata.yaml` is
    not needed. Of a file whose recorder was killed every complete chunk is read. The time of a sample is its header's
    stamp; where most messages have none, it is the time of receipt. Where the bag has `sensor_msgs/TimeReference`
    messages with the samples' stamps, they are the device's own times.

    A topic without a leading `/` that the bag does not have stands for its one topic of joint states of that name in
    a namespace.

    Raises BagError where something cannot be read or the topic holds no JointState.
    """
    asked, topic = topic, f"/{topic.lstrip('/')}"
    joints, devices, notes, types = _JointStates(bag), DeviceMessages(), [], dict[str, str]()
    files = storage_files(bag)
    budget = Budget(bag, sum(file.stat().st_size for file in files))
    for file in files:
        with _uncompressed(file, budget) as plain:
            notes += _read_file(plain, file, topic, joints, devices, types, budget)
    if types.get(topic) not in _MESSAGE_TYPES:
        suitable = sorted(name for name, message_type in types.items() if message_type in _MESSAGE_TYPES)
        in_namespaces = [name for name in suitable if not asked.startswith("/") and name.endswith(topic)]
        if topic not in types and len(in_namespaces) == 1:
            found = read_joint_states(bag, in_namespaces[0])
            return replace(found, notes=(f"joint states are those on {shown(in_namespaces[0])}", *found.notes))
        raise BagError("; ".join([_wrong_topic(bag, topic, types, suitable), *map(shown, notes)]))
    return _with_device(joints.recording(bag_name(bag), topic, notes), devices)


def is_storage_file(name: str) -> bool:
    """Return whether a file of this name holds messages of a bag."""
    return name.removesuffix(".zstd").endswith((".mcap", ".db3"))


def storage_files(bag: Path) -> list[Path]:
    """Return the files that hold the bag's messages, in the order in which they were recorded."""
    if bag.name == "metadata.yaml":
        bag = bag.parent
    try:
        if not bag.exists():
            raise BagError(f"there is no bag {bag}")
        if not bag.is_dir():
            return [bag]
        files = [file for file in bag.iterdir() if is_storage_file(file.name)]
    except (OSError, ValueError) as error:
        raise BagError(f"{bag} cannot be read: {error}") from error
    if not files:
        raise BagError(f"{bag} is not a rosbag2 bag: it holds no .mcap or .db3 file")
    # rosbag2 counts the files of a bag at the end of their names: _2 comes before _10.
    return sorted(files, key=lambda file: (len(file.name), file.name))


@contextmanager
def _uncompressed(file: Path, budget: Budget) -> Iterator[Path]:
    """Give the path of a file's content: itself, or a temporary file if it is compressed as a whole."""
    if not file.name.endswith(".zstd"):
        yield file
        return
    with TemporaryDirectory() as folder:
        plain = Path(folder) / file.name.removesuffix(".zstd")
        try:
            room = shutil.disk_usage(folder).free - _LEFT_FREE
            with (
                open_regular(file) as source,
                plain.open("wb") as target,
                zstandard.ZstdDecompressor(max_window_size=LARGEST_WINDOW).stream_reader(source) as stream,
            ):
                while block := stream.read(_BLOCK):
                    budget.spend(unfolded=len(block))
                    room -= len(block)
                    if room < 0:
                        raise BagError(f"{file} cannot be decompressed: {folder} has no room for it")
                    target.write(block)
        except (OSError, MemoryError, zstandard.ZstdError) as error:
            raise BagError(f"{file} cannot be decompressed: {error}") from error
        yield plain


def _read_file(
    file: Path,
    called: Path,
    topic: str,
    joints: _JointStates,
    devices: DeviceMessages,
    types: dict[str, str],
    budget: Budget,
) -> list[str]:
    """Add a file's messages to `joints` and `devices`, its topics to `types`; return what there is to say about it."""
    try:
        with open_regular(file) as stream:
            is_sqlite = stream.read(len(_SQLITE_MAGIC)) == _SQLITE_MAGIC
    except OSError as error:
        raise BagError(f"{called} cannot be read: {error.strerror or error}") from error
    if is_sqlite:
        types.update(sqlite_topics(file))
        if types.get(topic) in _MESSAGE_TYPES:
            for stamp, data in sqlite_messages(file, topic):
                budget.spend(unfolded=len(data), records=1)
                joints.add(stamp, data)
        for name, message_type in types.items():
            if message_type in DeviceMessages.TYPES:
                for _, data in sqlite_messages(file, name):
                    budget.spend(unfolded=len(data), records=1)
                    devices.add(name, message_type, data)
        return []
    scan = McapScan(file, budget)
    for channel, stamp, data in scan.messages():
        if channel.name == topic and channel.message_type in _MESSAGE_TYPES:
            joints.add(stamp, data)
        elif channel.message_type in DeviceMessages.TYPES:
            devices.add(channel.name, channel.message_type, data)
    types.update(scan.types())
    return [f"{called.name}: {damage}"] if (damage := scan.damage()) else []


def _wrong_topic(bag: Path, topic: str, types: dict[str, str], suitable: list[str]) -> str:
    if topic in types:
        found = f"topic {topic} of {bag} holds {shown(types[topic])}, not {MESSAGE_TYPE}"
    else:
        found = f"{bag} has no topic {topic}"
    if suitable:
        return f"{found}; joint states are on {shown(', '.join(suitable))}: name that topic"
    there = shown(", ".join(sorted(types))) or "no topics at all"
    return f"{found}; no topic of it holds joint states (it has {there})"


def _with_device(recording: JointRecording, devices: DeviceMessages) -> JointRecording:
    """Add the device's time to a recording; the few samples that lack it, at the ends, are dropped."""
    found = devices.device_time(recording.stamps)
    if found is None:
        return recording
    device, known = found
    notes = recording.notes
    if not np.all(known):
        notes = (*notes, f"{np.count_nonzero(~known)} samples without the device's own time are dropped")
    return replace(
        recording, stamps=recording.stamps[known], positions=recording.positions[known], notes=notes, device=device
    )


def bag_name(bag: Path) -> str:
    """Return what people call a bag."""
    if bag.name == "metadata.yaml":
        bag = bag.parent
    if bag.is_dir():
        return shown(bag.resolve().name)
    return shown(bag.name.removesuffix(".zstd").removesuffix(".mcap").removesuffix(".db3"))


@dataclass
class _Alike:
    """Messages of one layout: their rows in the recording, stamps and positions."""

    layout: Layout
    rows: array[int] = field(default_factory=lambda: array("q"))
    stamps: array[int] = field(default_factory=lambda: array("q"))
    positions: array[float] = field(default_factory=lambda: array("d"))

    def take(self, row: int, raw: bytes) -> bool:
        """Add a message if it has this layout, and say whether it had."""
        layout = self.layout
        fits = raw.startswith(layout.head, HEAD_OFFSET) and raw[:2] == layout.byte_order
        if not fits or len(raw) < layout.offset + layout.positions.size:
            return False
        seconds, nanoseconds = layout.stamp.unpack_from(raw, STAMP_OFFSET)
        if seconds < 0 or nanoseconds >= NANOSECONDS:
            raise ValueError("not a time")
        self.positions.extend(layout.positions.unpack_from(raw, layout.offset))
        self.stamps.append(seconds * NANOSECONDS + nanoseconds)
        self.rows.append(row)
        return True


class _JointStates:
    """Collects messages into arrays; a layout is found once and then serves all messages that begin alike."""

    def __init__(self, bag: Path) -> None:
        self._bag = bag
        self._receipts = array("q")
        self._groups: list[_Alike] = []
        self._at_hand: list[_Alike] = []
        self._joints: dict[str, None] = {}
        """Names of all joints, in the order in which they came."""
        self._garbled = 0

    def add(self, receipt: int, raw: bytes) -> None:
        """Add one message: its time of receipt [ns since the epoch] and its bytes."""
        row = len(self._receipts)
        try:
            raw = plain_message(raw)
            if not any(group.take(row, raw) for group in self._at_hand):
                self._begin_group(raw).take(row, raw)
        except (ValueError, struct.error):
            self._garbled += 1
        else:
            self._receipts.append(receipt)
            if row >= _MOST_ROWS or row * len(self._joints) > _MOST_VALUES:
                raise BagError(f"{self._bag} holds too many joint states ({row}): cut the swing out of it")

    def _begin_group(self, raw: bytes) -> _Alike:
        layout = parse_layout(raw)
        if len(layout.head) > _LONGEST_HEAD or len(layout.names) > _MOST_JOINTS:
            raise ValueError("more names than are believed")
        group = _Alike(layout)
        self._groups.append(group)
        self._at_hand = [group, *self._at_hand[: _LAYOUTS_AT_HAND - 1]]
        self._joints |= dict.fromkeys(layout.names)
        if len(self._joints) > _MOST_JOINTS or len(self._groups) > _MOST_LAYOUTS:
            raise BagError(
                f"{self._bag} names {len(self._joints)} joints in {len(self._groups)} ways: at most {_MOST_JOINTS} and "
                f"{_MOST_LAYOUTS} are believed"
            )
        return group

    def recording(self, name: str, topic: str, notes: list[str]) -> JointRecording:
        """Return all messages as one recording, in the order of their receipt."""
        joints = tuple(self._joints)
        column = {joint: i for i, joint in enumerate(joints)}
        positions = np.full((len(self._receipts), len(joints)), np.nan)
        stamps = np.zeros(len(self._receipts), dtype=np.int64)
        receipts = np.array(self._receipts, dtype=np.int64)
        for group in self._groups:
            rows = np.array(group.rows, dtype=np.int64)
            stamps[rows] = group.stamps
            values = np.array(group.positions).reshape(len(rows), len(group.layout.names))
            positions[rows[:, None], [column[joint] for joint in group.layout.names]] = values
        notes = list(notes)
        if self._garbled:
            notes.append(f"{self._garbled} messages on {topic} that are not well-formed joint states are dropped")
        times, keep, note = _times(stamps, receipts)
        keep = keep[np.argsort(receipts[keep], kind="stable")]
        return JointRecording(name, topic, joints, times[keep], positions[keep], (*notes, *note))


def _times(
    stamps: npt.NDArray[np.int64], receipts: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], list[str]]:
    """Choose between the stamps of the headers and the times of receipt.

    Returns the times (n,), the samples that have one, and what there is to say about it.
    """
    stamped = stamps > 0
    count = int(np.count_nonzero(stamped))
    if 2 * count < len(stamps) or not len(stamps):
        note = ["the messages have no stamp: the time of receipt is used, with its jitter"] if len(stamps) else []
        return receipts, np.arange(len(stamps)), note
    unstamped = len(stamps) - count
    note = [f"{unstamped} messages without a stamp are dropped"] if unstamped else []
    return stamps, np.flatnonzero(stamped), note
