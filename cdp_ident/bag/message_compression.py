"""Messages that rosbag2 has compressed one by one."""

from cdp_ident.bag.limits import LARGEST_MESSAGE, decompressed

_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


def plain_message(raw: bytes) -> bytes:
    """Return the serialised message that may be compressed in `raw`.

    Raises ValueError where it cannot be decompressed, or is larger than a mebibyte.
    """
    return decompressed(raw, "zstd", LARGEST_MESSAGE) if raw[:4] == _ZSTD_MAGIC else raw
