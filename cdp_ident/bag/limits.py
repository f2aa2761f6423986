# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Limits on decompressing a bag: a few kilobytes can claim, or be compressed from, any amount of data."""

from io import BytesIO
from pathlib import Path

import lz4.frame
import zstandard

from cdp_ident.errors import BagError

LARGEST_CHUNK = 1 << 27
"""Largest uncompressed chunk that is accepted [bytes]; recorders make chunks of about 1 MB."""
LARGEST_MESSAGE = 1 << 20
"""Bytes of a message with joint states."""
LARGEST_SCHEMA = 1 << 17
MOST_TOPICS = 4096
_BYTES, _BYTES_PER_BYTE = 1 << 30, 8
"""Bytes that may be decompressed from any bag, and from each byte of it on the disk: camera images hardly shrink."""
_RECORDS, _BYTES_PER_RECORD = 10_000_000, 64
"""Records of any bag, and bytes on the disk for which there may be another one."""
_BLOCK = 1 << 20
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
LARGEST_WINDOW = 1 << 27
"""Bytes that zstd may look back; `zstd --ultra --long=27` writes no more."""


class Budget:
    """What reading one bag may cost."""

    def __init__(self, bag: Path, size: int) -> None:
        """`size` is that of the bag's files on the disk [bytes]."""
        self._bag = bag
        self._bytes = _BYTES + _BYTES_PER_BYTE * size
        self._records = _RECORDS + size // _BYTES_PER_RECORD

    def spend(self, *, unfolded: int = 0, records: int = 0) -> None:
        """Take bytes that are unfolded, and records. Raises BagError where they become too many."""
        self._bytes -= unfolded
        self._records -= records
        if self._bytes < 0 or self._records < 0:
            what = "bytes" if self._bytes < 0 else "records"
            raise BagError(
                f"{self._bag} unfolds to far more {what} than a file of its size should: it is not read any further; "
                "cut the swing out with `ros2 bag convert` if it is a recording"
            )


def decompressed(data: bytes, compression: str, most: int) -> bytes:
    """Return what `data` was compressed from with `zstd` or `lz4`, in memory for no more than is there and `most`.

    Raises ValueError where that is more than `most` bytes, or where the data are damaged.
    """
    result, packed = bytearray(), BytesIO(data)
    try:
        if compression == "lz4":
            stream = lz4.frame.open(packed)
        elif compression == "zstd":
            stream = zstandard.ZstdDecompressor(max_window_size=LARGEST_WINDOW).stream_reader(packed)
        else:
            raise ValueError(f"the compression {compression[:20]!r} is not known")
        with stream:
            while len(result) <= most and (block := stream.read(_BLOCK)):
                result += block
    except (zstandard.ZstdError, EOFError, RuntimeError, MemoryError) as error:
        raise ValueError(f"damaged {compression} data: {error}") from error
    if len(result) > most:
        raise ValueError(f"more than {most} bytes are compressed")
    return bytes(result)


def plain_message(raw: bytes) -> bytes:
    """Return the serialised message that rosbag2 may have compressed in `raw`.

    Raises ValueError where it cannot be decompressed, or is larger than a mebibyte.
    """
    return decompressed(raw, "zstd", LARGEST_MESSAGE) if raw[:4] == _ZSTD_MAGIC else raw
