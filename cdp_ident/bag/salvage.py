# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Completing a bag whose recorder was killed: its MCAP file lacks the end, and `metadata.yaml` is missing or stale."""

import fcntl
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from mcap.writer import MCAP0_MAGIC

from cdp_ident.bag.limits import Budget
from cdp_ident.bag.mcap_scan import McapScan
from cdp_ident.bag.metadata import METADATA_FILE, read_offered
from cdp_ident.bag.writer import BagWriter
from cdp_ident.errors import BagError
from cdp_ident.files import beside, open_regular, remove_unfinished


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
