# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reading the joint positions of any rosbag2 bag."""

from __future__ import annotations

import hashlib
import shutil
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import zstandard

from cdp_ident.bag.joint_recording import DeviceMessages, JointRecording, JointStates
from cdp_ident.bag.joint_state import MESSAGE_TYPE
from cdp_ident.bag.limits import LARGEST_WINDOW, Budget
from cdp_ident.bag.mcap_scan import NO_BAG, ROS1, McapScan
from cdp_ident.bag.metadata import METADATA_FILE, Metadata
from cdp_ident.bag.sqlite_scan import sqlite_messages, sqlite_topics
from cdp_ident.errors import BagError
from cdp_ident.files import open_regular
from cdp_ident.outside_text import shown

_MESSAGE_TYPES = (MESSAGE_TYPE, "sensor_msgs/JointState")
_SQLITE_MAGIC = b"SQLite format 3\0"
_CONVERT = {"ros1": "; convert the ROS 1 recording with `rosbags-convert`", "json": "; record it with ROS 2"}
_LONGEST_ERROR = 1000
_BLOCK = 1 << 20
_LEFT_FREE = 100_000_000
"""So much of the disk with the temporary files is left to others [bytes]."""


def read_joint_states(bag: Path, topic: str) -> JointRecording:
    """Read the JointState messages on a topic of a rosbag2 bag; the bag itself is not changed.

    `bag` is a folder or one .mcap or .db3 file, also compressed as a whole (.zstd) or by message. `metadata.yaml` is
    not needed; where it names some of the folder's files, these are read. Of a file whose recorder was killed every
    complete chunk is read, and of several files those that can be. Where the bag has `sensor_msgs/TimeReference`
    messages with the samples' stamps, they are the device's own times.

    `topic` may name several, with blanks between, as of joints that have a topic each. One without a leading `/` that
    the bag does not have stands for its one topic of joint states of that name in a namespace.

    Raises BagError where something cannot be read or the topic holds no JointState that can be used.
    """
    try:
        return _read(bag, topic)
    except (BagError, OSError, ValueError, RuntimeError) as error:
        text = str(error) if isinstance(error, BagError) else f"{bag} cannot be read: {error}"
        raise BagError(shown(text, _LONGEST_ERROR)) from error


def _read(bag: Path, asked: str) -> JointRecording:
    files, metadata, notes = _recorded_files(bag)
    topics = tuple(f"/{name.lstrip('/')}" for name in asked.split())
    # What is wrong with a file is told where it is opened.
    size = sum(file.stat().st_size for file in files if file.exists())
    contents = _Contents(topics, JointStates(bag), DeviceMessages(), Budget(bag, size))
    topic, joints = " ".join(topics), contents.joints
    for file in files:
        try:
            with _uncompressed(file, contents.budget) as plain:
                notes += contents.add(plain, file)
        except BagError as error:
            if len(files) == 1:
                raise
            notes.append(f"nothing more is read of {file.name}: {error}")
    suitable = sorted(name for name, message_type in contents.types.items() if message_type in _MESSAGE_TYPES)
    in_namespaces = [name for name in suitable if not asked.startswith("/") and name.endswith(topic)]
    if topic not in contents.types and len(in_namespaces) == 1:
        found = _read(bag, in_namespaces[0])
        return replace(found, notes=(f"joint states are those on {shown(in_namespaces[0])}", *found.notes))
    others = [name for name in suitable if name not in topics and contents.counts[name]]
    if not len(joints):
        raise BagError("; ".join([_nothing(bag, contents, others), *map(shown, notes)]))
    here, there = sum(contents.counts[name] for name in topics), metadata.count(topics)
    notes += [f"{there - here} of the {there} messages that {METADATA_FILE} counts are missing"] if here < there else []
    notes += [f"joint states on {shown(', '.join(others))} are not read"] if others else []
    return contents.devices.added_to(joints.recording(bag_name(bag), topic, notes))


def is_storage_file(name: str) -> bool:
    """Return whether a file of this name holds messages of a bag; hidden files are those of other systems."""
    return name.removesuffix(".zstd").endswith((".mcap", ".db3")) and not name.startswith(".")


def no_bag(bag: Path) -> str:
    """Say that a bag is not there; a pattern that the shell left as it is has found none."""
    if set(bag.name) & set("*?["):
        return f"there is no bag in {bag.parent} that is called {bag.name}"
    return f"there is no bag {bag}"


def storage_files(bag: Path) -> list[Path]:
    """Return the files that hold the bag's messages, in the order in which they were recorded."""
    if bag.name == METADATA_FILE:
        bag = bag.parent
    try:
        if not bag.exists():
            raise BagError(no_bag(bag))
        if not bag.is_dir():
            return [bag]
        named = [path for path in Metadata.of(bag).paths if not path.is_absolute() and ".." not in path.parts]
        there = sorted({*bag.iterdir(), *filter(Path.is_file, (bag / path for path in named))})
    except (OSError, ValueError) as error:
        raise BagError(f"{bag} cannot be read: {error}") from error
    files = [file for file in there if is_storage_file(file.name)]
    if not files:
        what = next((f"{file} is {ROS1.format(path=file)}" for file in there if file.suffix == ".bag"), "")
        raise BagError(what or f"{bag} is not a rosbag2 bag: it holds no .mcap or .db3 file; {NO_BAG}")
    # rosbag2 counts the files of a bag at the end of their names: _2 comes before _10.
    return sorted(files, key=lambda file: (len(file.name), file.name))


def bag_checksums(bag: Path) -> dict[str, str]:
    """Return the SHA-256 of each file that holds messages of a bag, by the file's name.

    Raises:
        BagError: a file cannot be read.
    """
    checksums = {}
    try:
        for file in filter(Path.is_file, storage_files(bag)):  # others are not read, and that is said
            with open_regular(file) as stream:
                digest = hashlib.sha256()
                while block := stream.read(1 << 20):
                    digest.update(block)
            checksums[file.name] = digest.hexdigest()
    except (OSError, ValueError) as error:
        raise BagError(f"{bag} cannot be read: {getattr(error, 'strerror', None) or error}") from error
    return checksums


def _recorded_files(bag: Path) -> tuple[list[Path], Metadata, list[str]]:
    """Return the files of a bag that are read, what `metadata.yaml` says of all of it, and what to say of other files.

    They are those that it names. Where it names none that is there, the files were given other names.
    """
    files = storage_files(bag)
    if not bag.is_dir() and bag.name != METADATA_FILE:
        return files, Metadata({}), []
    metadata = Metadata.of(bag)
    # Older recorders name a file as it was before they compressed it.
    there = {file: {file.name, file.name.removesuffix(".zstd")} & metadata.files for file in files}
    recorded = [file for file in files if there[file]]
    if not recorded:
        called = shown(", ".join(file.name for file in files))
        renamed = f"no file that {METADATA_FILE} names is there (renamed, or in another folder?): read is {called}"
        return files, metadata, [renamed] if metadata.files else []
    missing, others = (
        sorted(metadata.files - set().union(*there.values())),
        [file.name for file in files if not there[file]],
    )
    notes = []
    if missing:
        notes.append(
            f"not there, though {METADATA_FILE} names it: {shown(', '.join(missing))}; what it held is missing"
        )
    if others:
        notes.append(f"not read, as {METADATA_FILE} does not name it: {shown(', '.join(others))}")
    return recorded, metadata, notes


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


@dataclass
class _Contents:
    """What is read of a bag's files."""

    topics: tuple[str, ...]
    """Whose joint states are read."""
    joints: JointStates
    devices: DeviceMessages
    budget: Budget
    types: dict[str, str] = field(default_factory=dict)
    """Message types of all topics."""
    counts: Counter[str] = field(default_factory=Counter)
    """Messages of topics with joint states."""

    def add(self, file: Path, called: Path) -> list[str]:
        """Add a file's contents; return what there is to say about it."""
        try:
            with open_regular(file) as stream:
                is_sqlite = stream.read(len(_SQLITE_MAGIC)) == _SQLITE_MAGIC
        except OSError as error:
            raise BagError(f"{called} cannot be read: {error.strerror or error}") from error
        if is_sqlite:
            self.types.update(sqlite_topics(file))
            for name, message_type in self.types.items():
                if message_type in (*_MESSAGE_TYPES, *DeviceMessages.TYPES):
                    for receipt, data in sqlite_messages(file, name):
                        self.budget.spend(unfolded=len(data), records=1)
                        self._take(name, message_type, receipt, data)
            return []
        scan = McapScan(file, self.budget)
        for channel, schema, receipt, data in scan.messages():
            self._take(channel.topic, schema.name, receipt, data, channel.message_encoding)
        self.types.update(scan.types())
        return [f"{called.name}: {damage}"] if (damage := scan.damage()) else []

    def _take(self, topic: str, message_type: str, receipt: int, data: bytes, encoding: str = "cdr") -> None:
        if message_type in DeviceMessages.TYPES:
            self.devices.add(topic, message_type, data)
        elif message_type in _MESSAGE_TYPES:
            self.counts[topic] += 1
            if topic in self.topics and encoding == "cdr":
                self.joints.add(receipt, data)
            elif topic in self.topics:
                self.joints.drop(f"are encoded as {encoding[:20]}: expected cdr{_CONVERT.get(encoding, '')}")


def _nothing(bag: Path, contents: _Contents, others: list[str]) -> str:
    """Say why there is no joint state on the topic, and which other topics have some."""
    topic, types = contents.topics[0], contents.types
    if topic not in types:
        found = f"{bag} has no topic {topic}"
    elif types[topic] not in _MESSAGE_TYPES:
        found = f"topic {topic} of {bag} holds {shown(types[topic]) or 'messages of unknown type'}, not {MESSAGE_TYPE}"
    elif contents.counts[topic]:
        found = f"{bag}: no message on {topic} is a joint state that can be used; {contents.joints.dropped}"
    else:
        found = f"there is no message on {topic} of {bag} (did its publisher offer another quality of service?)"
    if others:
        return (
            f"{found}; joint states are on {shown(', '.join(others))}: name that topic, or several with blanks between"
        )
    there = shown(", ".join(sorted(types))) or "no topics at all"
    return found if contents.counts[topic] else f"{found}; no topic of it holds joint states (it has {there})"


def bag_name(bag: Path) -> str:
    """Return what people call a bag."""
    if bag.name == METADATA_FILE:
        bag = bag.parent
    if bag.is_dir():
        return shown(bag.resolve().name)
    return shown(bag.name.removesuffix(".zstd").removesuffix(".mcap").removesuffix(".db3"))
