# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Damage: what cables, disks and people do to bytes."""

import random

_EXTREMES = (b"\0" * 4, b"\xff" * 4, b"\xff" * 8, b"\x7f" + b"\xff" * 7, b"\0" * 16, b"\xff\xff\xff\x7f")


def mutated(content: bytes, generator: random.Random) -> bytes:
    """Return bytes with one to four changes: bits, bytes, cuts, repetitions, swaps, and numbers that are extreme."""
    result = bytearray(content)
    for _ in range(generator.choice((1, 1, 1, 2, 4))):
        _change(result, generator)
    return bytes(result)


def _change(content: bytearray, generator: random.Random) -> None:
    size = len(content)
    if size == 0:
        content += generator.randbytes(generator.randint(1, 8))
        return
    at = generator.randrange(size)
    length = min(size - at, generator.choice((1, 2, 4, 8, 64, 1024)))
    kind = generator.randrange(9)
    if kind <= 2:
        content[at] ^= 1 << generator.randrange(8)
    elif kind == 3:
        content[at] = generator.randrange(256)
    elif kind == 4:
        extreme = generator.choice(_EXTREMES)
        content[at : at + len(extreme)] = extreme
    elif kind == 5:
        del content[at : at + length]
    elif kind == 6:
        content[at:at] = content[at : at + length] * generator.randint(1, 3)
    elif kind == 7:
        other = generator.randrange(size)
        content[at : at + length], content[other : other + length] = (
            content[other : other + length],
            content[at : at + length],
        )
    else:
        del content[at:]


_WORDS = (
    "!!int ''", "!!timestamp x", "&a [*a]", "1" * 400, "0x" + "f" * 2000, "[" * 500, "{a: " * 200, ".nan", "-.inf",
    "2024-99-99", "\x1b[2J", "\u202e", "../../x", "null", "''", "- ", ":", "9" * 30, "1e308", "true", "\\u0000", "NaN",
    "{}", "[[[[[[]]]]]]", '"' + "x" * 5000 + '"', "%d%n", "\0",
)  # fmt: skip


def mutated_text(content: bytes, generator: random.Random) -> bytes:
    """Return a text with damage, or with a word of it replaced by another one of it or by one that is hostile."""
    if generator.random() < 0.3:
        return mutated(content, generator)
    words = content.replace(b":", b" : ").replace(b",", b" , ").split(b" ")
    for _ in range(generator.choice((1, 1, 2, 5))):
        word = generator.choice(_WORDS).encode() if generator.random() < 0.7 else generator.choice(words)
        words[generator.randrange(len(words))] = word
    return b" ".join(words)
