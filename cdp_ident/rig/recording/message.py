"""A message as a recorder gets it."""

from typing import NamedTuple


class Message(NamedTuple):
    """A serialised message."""

    topic: str
    message_type: str
    received_ns: int
    """Time of its receipt [ns since the epoch]."""
    raw: bytes
