# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One pass through an SQLite file of a rosbag2 bag."""

import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote

from cdp_ident.bag.limits import LARGEST_MESSAGE, MOST_TOPICS
from cdp_ident.errors import BagError

_COLUMNS = {"topics": ("id", "name", "type"), "messages": ("topic_id", "timestamp", "data")}
"""What rosbag2's tables have that is read."""
_LARGEST_JOURNAL = 1 << 30
"""Bytes of a file with a journal, which is copied to be read."""
_KIND = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ? AND rootpage > 0"
_PLAIN = "SELECT count(*) FROM pragma_table_xinfo(?) WHERE name = ? AND hidden = 0"
_TOPICS = (
    "SELECT name, type FROM topics WHERE typeof(name) = 'text' AND typeof(type) = 'text' AND length(name) <= 1000 "
    f"AND length(type) <= 1000 LIMIT {MOST_TOPICS}"
)
_MESSAGES = (
    "SELECT timestamp, data FROM messages WHERE topic_id IN (SELECT id FROM topics WHERE name = ?) "
    f"AND typeof(timestamp) = 'integer' AND typeof(data) = 'blob' AND length(data) <= {LARGEST_MESSAGE}"
)


def sqlite_topics(path: Path) -> dict[str, str]:
    """Return the message type of each topic of the file. Raises BagError where it cannot be read."""
    with _database(path) as database:
        return dict(database.execute(_TOPICS))


def sqlite_messages(path: Path, topic: str) -> Iterator[tuple[int, bytes]]:
    """Yield time of receipt [ns since the epoch] and serialised bytes of each message of a topic.

    Raises BagError where the file cannot be read.
    """
    with _database(path) as database:
        yield from database.execute(_MESSAGES, (topic,))


@contextmanager
def _database(path: Path) -> Iterator[sqlite3.Connection]:
    """Open a file for reading only, with what a killed recorder left in its journal; the bag stays as it is.

    Only what is stored is read: a view, a virtual table or a generated column could compute anything.
    """
    try:
        with TemporaryDirectory() as copies:
            place, mode = _with_journals(path, Path(copies))
            with closing(sqlite3.connect(f"file:{quote(os.fsencode(place))}?{mode}", uri=True)) as database:
                database.execute("PRAGMA trusted_schema = OFF")
                database.execute("PRAGMA query_only = ON")
                for table, columns in _COLUMNS.items():
                    if database.execute(_KIND, (table,)).fetchone() != (1,):
                        raise BagError(
                            f"{path} is an SQLite file but not a rosbag2 recording: it lacks rosbag2's tables"
                        )
                    for column in columns:
                        if database.execute(_PLAIN, (table, column)).fetchone() != (1,):
                            raise BagError(f"{path} is not read: column {column} of its table {table} is not stored")
                yield database
    except (sqlite3.Error, OSError, MemoryError, UnicodeDecodeError) as error:
        raise BagError(f"{path} cannot be read: {error}") from error


def _with_journals(path: Path, copies: Path) -> tuple[Path, str]:
    """Return the file to open, and how: SQLite works a journal into the file as it opens it, so into a copy."""
    journals = [path.with_name(path.name + ending) for ending in ("-wal", "-journal")]
    journals = [journal for journal in journals if journal.is_file()]
    if not journals:
        return path.resolve(), "mode=ro&immutable=1"
    if sum(file.stat().st_size for file in (path, *journals)) > min(_LARGEST_JOURNAL, shutil.disk_usage(copies).free):
        raise BagError(f"{path} has a journal and is too large to be copied: open it with `sqlite3` once, and close it")
    for file in (path, *journals):
        shutil.copy(file, copies)
    return copies / path.name, "mode=rw"
