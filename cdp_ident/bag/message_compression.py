"""Messages that rosbag2 has compressed one by one."""

import zstandard

_MAGIC = b"\x28\xb5\x2f\xfd"
_LARGEST = 1 << 20


def plain_message(raw: bytes) -> bytes:
    """Return the serialised message that may be compressed in `raw`.

    Raises `zstandard.ZstdError` or MemoryError where it cannot be decompressed, or is larger than a mebibyte.
    """
    return zstandard.ZstdDecompressor().decompress(raw, max_output_size=_LARGEST) if raw[:4] == _MAGIC else raw
