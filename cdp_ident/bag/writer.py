# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Writing a rosbag2 folder, one MCAP file and its `metadata.yaml`, and completing one whose recorder was killed."""

import fcntl
import os
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.writer import MCAP0_MAGIC, Writer
from rosbags.typesys.base import TypesysError

from cdp_ident.bag.joint_state import typestore
from cdp_ident.bag.limits import Budget
from cdp_ident.bag.mcap_scan import McapScan
from cdp_ident.bag.metadata import (
    INFORMATION,
    METADATA_FILE,
    OFFERED_QOS_PROFILES,
    ROS_DISTRO,
    QosProfile,
    dump_yaml,
    read_offered,
)
from cdp_ident.errors import BagError
from cdp_ident.files import beside, open_regular, remove_unfinished, write_whole


@dataclass
class _Topic:
    """A topic that is declared."""

    channel: int
    metadata: dict[str, Any]
    """What `metadata.yaml` says of it."""
    message_count: int = 0


class BagWriter:
    """Writes messages into a new rosbag2 folder that rosbag2, rosbags and Foxglove read.

    What was written before a `flush` is still there after SIGKILL: the file then lacks its end, which `complete_bag`
    writes. As a context manager it closes the bag, also when an error passes through.
    """

    def __init__(self, folder: Path, file_name: str | None = None) -> None:
        """Make the folder, which must not exist, and begin the file `<folder's name>_0.mcap` (or `file_name`) in it.

        Raises BagError where the folder exists or cannot be written.
        """
        self.folder = folder
        self._failed = False
        self._path = folder / (file_name or f"{folder.resolve().name}_0.mcap")
        try:
            folder.mkdir(parents=True)
            unlocked = folder / f".{self._path.name}.unlocked"
            self._stream = unlocked.open("xb")
            with suppress(OSError):  # file systems without locks
                fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)  # tells `complete_bag` that the recorder lives
            unlocked.rename(self._path)
        except FileExistsError as error:
            raise BagError(f"{folder} exists already and is not overwritten: give another folder") from error
        except OSError as error:
            raise self._failure(error) from error
        self._writer = Writer(self._stream)
        self._writer.start(profile="ros2")
        self._schemas: dict[str, int] = {}
        self._topics: dict[str, _Topic] = {}
        self._start_ns = self._end_ns = 0

    @property
    def message_count(self) -> int:
        """Messages written so far."""
        return sum(topic.message_count for topic in self._topics.values())

    @property
    def duration_ns(self) -> int:
        """Time from the first to the last message so far [ns]."""
        return self._end_ns - self._start_ns

    @property
    def topics(self) -> Collection[str]:
        """The topics declared so far."""
        return self._topics.keys()

    def add_topic(
        self,
        topic: str,
        message_type: str,
        schema: tuple[str, bytes] | None = None,
        type_hash: str = "",
        offered: Sequence[QosProfile] = OFFERED_QOS_PROFILES,
    ) -> None:
        """Declare a topic; `write` does so by itself for the message types of ROS's common interfaces.

        `message_type` is the full name (`sensor_msgs/msg/JointState`); `schema` is the encoding (`ros2msg`, `ros2idl`)
        and text of its definition and `type_hash` its hash, where it is not one of those; `offered` is the quality of
        service of its publishers. Raises BagError where the type is not known, or the topic is there with another type.
        """
        if topic in self._topics:
            known = self._topics[topic].metadata["type"]
            if known != message_type:
                raise BagError(f"topic {topic} of {self.folder} holds {known}: {message_type} cannot go there too")
            return
        if schema is None:
            try:
                definition, _ = typestore().generate_msgdef(message_type, ros_version=2)
                type_hash = typestore().hash_rihs01(message_type)
            except (TypesysError, KeyError) as error:
                raise BagError(f"{message_type} of topic {topic} is not a message type of ROS's interfaces") from error
            schema = ("ros2msg", definition.encode())
        if message_type not in self._schemas:
            self._schemas[message_type] = self._writer.register_schema(message_type, *schema)
        described = {"offered_qos_profiles": dump_yaml(list(offered)), "topic_type_hash": type_hash}
        channel = self._writer.register_channel(topic, "cdr", self._schemas[message_type], described)
        metadata = {
            "name": topic,
            "type": message_type,
            "serialization_format": "cdr",
            "offered_qos_profiles": list(offered),
            "type_description_hash": type_hash,
        }
        self._topics[topic] = _Topic(channel, metadata)

    def write(self, topic: str, message_type: str, stamp_ns: int, cdr_bytes: bytes) -> None:
        """Write one serialised message that was received at `stamp_ns` [ns since the epoch].

        Raises BagError where the disk does not take it or the type does not fit the topic.
        """
        self.add_topic(topic, message_type)
        if not 0 <= stamp_ns < 2**63:
            raise BagError(f"a message of topic {topic} has the time {stamp_ns} ns: expected 0 to 2^63 - 1 since 1970")
        if self._stream.closed:
            raise BagError(f"the bag {self.folder} is closed, or a write to it failed before: begin another")
        of = self._topics[topic]
        try:
            self._writer.add_message(of.channel, stamp_ns, cdr_bytes, publish_time=stamp_ns, sequence=of.message_count)
        except OSError as error:
            raise self._failure(error) from error
        self._start_ns = min(self._start_ns, stamp_ns) if self.message_count else stamp_ns
        self._end_ns = max(self._end_ns, stamp_ns)
        of.message_count += 1

    def flush(self) -> None:
        """Hand everything written so far to the operating system, as a chunk of its own.

        It then outlives this process, not a power cut: only `close` waits for the disk. Raises BagError where the disk
        does not take it, or the file was removed: it would take everything, for nobody.
        """
        if self._stream.closed:
            return
        try:
            self._writer.flush()
            if not os.fstat(self._stream.fileno()).st_nlink and not self._path.exists():
                raise FileNotFoundError("it was removed meanwhile")
        except OSError as error:
            raise self._failure(error) from error

    def close(self, custom_data: Mapping[str, str] | None = None) -> None:
        """Complete the file and write `metadata.yaml`, with `custom_data` in it; both are on the disk afterwards.

        Closing again does nothing. Raises BagError where the disk does not take it, or did not take something before:
        the bag then stays as a killed recorder would leave it.
        """
        if self._failed:
            raise BagError(f"the bag {self.folder} is incomplete: a write to it failed before")
        if self._stream.closed:
            return
        information = self._information(custom_data or {})
        text = dump_yaml({INFORMATION: information})
        try:
            self._writer.add_metadata("rosbag2", {"serialized_metadata": dump_yaml(information)})
            self._writer.finish()
            self._stream.flush()
            os.fsync(self._stream.fileno())
            write_whole({self.folder / METADATA_FILE: text.encode()})
            self._stream.close()  # and with it the lock: without metadata the bag would look unfinished
        except OSError as error:
            raise self._failure(error) from error

    def _information(self, custom_data: Mapping[str, str]) -> dict[str, Any]:
        """Return what `metadata.yaml` holds under `INFORMATION`."""
        file_name, count = self._path.name, self.message_count
        start = {"nanoseconds_since_epoch": self._start_ns}
        duration = {"nanoseconds": self.duration_ns}
        return {
            "version": 9,  # that of ROS_DISTRO
            "storage_identifier": "mcap",
            "duration": duration,
            "starting_time": start,
            "message_count": count,
            "topics_with_message_count": [
                {"topic_metadata": topic.metadata, "message_count": topic.message_count}
                for topic in self._topics.values()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file_name],
            "files": [{"path": file_name, "starting_time": start, "duration": duration, "message_count": count}],
            "custom_data": dict(custom_data) or None,
            "ros_distro": ROS_DISTRO,
        }

    def __enter__(self) -> "BagWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        with suppress(BagError) if error else nullcontext():
            self.close()

    def _failure(self, error: OSError) -> BagError:
        """End the writing: behind half a record nothing more could be read, and what is before it can be completed."""
        self._failed = True
        if hasattr(self, "_stream"):
            with suppress(OSError):
                self._stream.close()
        return BagError(f"the bag {self.folder} cannot be written: {error.strerror or error}")


@dataclass(frozen=True)
class Salvaged:
    """What of a bag was kept and what was lost."""

    bag: Path
    messages: int
    """Messages kept."""
    span: float
    """Time from the first to the last message kept [s]."""
    damage: str
    """What could not be read, in words; empty if everything could."""

    def __str__(self) -> str:
        return (
            f"{self.bag}: completed with {self.messages} messages over {self.span:.3f} s; {self.damage or 'none lost'}"
        )


def is_incomplete(folder: Path) -> bool:
    """Say whether a folder is a bag of MCAP files whose recorder did not finish it."""
    try:
        files = list(folder.glob("*.mcap"))
        return bool(files) and not ((folder / METADATA_FILE).is_file() and all(_is_finished(file) for file in files))
    except FileNotFoundError:  # another recorder is completing it
        return False
    except OSError as error:
        raise BagError(f"{folder} cannot be read: {error.strerror or error}") from error


def complete_bag(folder: Path) -> Salvaged | None:
    """Make an ordinary bag of one whose recorder was killed, with every message that is readable.

    Returns None where it is complete already: another recorder was quicker.

    The file is written anew beside the old one and takes its place only when it is complete on the disk. Where more
    than the end is damaged, the old file is kept too, as `<name>.mcap.damaged`. Raises BagError where the bag is still
    being recorded, holds nothing readable, has several files, or the disk does not take it; the bag is then unchanged.
    """
    files = sorted(folder.glob("*.mcap"))
    if len(files) != 1:
        raise BagError(f"{folder} has {len(files)} .mcap files: expected one; `ros2 bag reindex` makes bags of several")
    (original,) = files
    unfinished = beside(original)
    with _exclusively(original):
        if not is_incomplete(folder):
            return None
        try:
            remove_unfinished(folder)
            salvaged, damaged = _write_anew(original, unfinished)
            if damaged:
                kept = f"{original.name}.damaged"
                shutil.copy2(original, unfinished / kept)
                (unfinished / kept).replace(folder / kept)
            # The file last: with it goes the lock, and who comes then finds nothing left to do.
            (unfinished / METADATA_FILE).replace(folder / METADATA_FILE)
            (unfinished / original.name).replace(original)
        except OSError as error:
            raise BagError(f"{folder} cannot be completed: {error.strerror or error}") from error
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)
    return salvaged


def _write_anew(original: Path, folder: Path) -> tuple[Salvaged, bool]:
    """Return what was kept, and whether more than the end of the file is missing."""
    scan = McapScan(original, Budget(original, original.stat().st_size))
    with BagWriter(folder, original.name) as writer:
        for channel, schema, stamp, data in scan.messages():
            if channel.topic not in writer.topics:
                type_hash = channel.metadata.get("topic_type_hash", "")
                offered = read_offered(channel.metadata.get("offered_qos_profiles", ""))
                writer.add_topic(channel.topic, schema.name, (schema.encoding, schema.data), type_hash, offered)
            writer.write(channel.topic, schema.name, stamp, data)
        salvaged = Salvaged(original.parent, writer.message_count, writer.duration_ns * 1e-9, scan.damage())
        writer.close({"salvaged": str(salvaged)})
    return salvaged, scan.lacks_more_than_its_end


def _is_finished(file: Path) -> bool:
    """Say whether a file ends as an MCAP file does."""
    with open_regular(file) as stream:
        stream.seek(0, 2)
        stream.seek(max(0, stream.tell() - len(MCAP0_MAGIC)))
        return stream.read() == bytes(MCAP0_MAGIC)


@contextmanager
def _exclusively(file: Path) -> Iterator[None]:
    """Hold the lock that a BagWriter has on its file as long as it lives."""
    try:
        with open_regular(file) as stream:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
    except BlockingIOError as error:
        raise BagError(f"{file} is still being recorded: stop its recorder first") from error
    except OSError as error:
        raise BagError(f"{file} cannot be read: {error.strerror or error}") from error
