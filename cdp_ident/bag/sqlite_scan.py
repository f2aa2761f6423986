"""One pass through an SQLite file of a rosbag2 bag."""

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import quote

from cdp_ident.errors import BagError

_TABLES = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('messages', 'topics')"
_TOPICS = "SELECT name, type FROM topics"
_MESSAGES = (
    "SELECT messages.timestamp, messages.data FROM messages JOIN topics ON messages.topic_id = topics.id "
    "WHERE topics.name = ? AND typeof(messages.timestamp) = 'integer' AND typeof(messages.data) = 'blob'"
)


def sqlite_topics(path: Path) -> dict[str, str]:
    """Return the message type of each topic of the file. Raises BagError where it cannot be read."""
    with _database(path) as database:
        return {str(name): str(message_type) for name, message_type in database.execute(_TOPICS)}


def sqlite_messages(path: Path, topic: str) -> Iterator[tuple[int, bytes]]:
    """Yield time of receipt [ns since the epoch] and serialised bytes of each message of a topic.

    Raises BagError where the file cannot be read.
    """
    with _database(path) as database:
        yield from database.execute(_MESSAGES, (topic,))


@contextmanager
def _database(path: Path) -> Iterator[sqlite3.Connection]:
    """Open a file for reading only, with what a killed recorder left in its journal; the bag stays as it is."""
    try:
        with TemporaryDirectory() as copies:
            journals = [path.with_name(path.name + ending) for ending in ("-wal", "-journal")]
            journals = [journal for journal in journals if journal.is_file()]
            place, mode = path.resolve(), "immutable=1"
            if journals:
                # SQLite works the journal into the file as it opens it: into a copy.
                for file in (path, *journals):
                    shutil.copy(file, copies)
                place, mode = Path(copies) / path.name, "mode=rw"
            with closing(sqlite3.connect(f"file:{quote(str(place))}?{mode}", uri=True)) as database:
                if database.execute(_TABLES).fetchone() != (2,):
                    raise BagError(f"{path} is an SQLite file but not a rosbag2 recording: it lacks rosbag2's tables")
                yield database
    except (sqlite3.Error, OSError, MemoryError, UnicodeDecodeError) as error:
        raise BagError(f"{path} cannot be read: {error}") from error
