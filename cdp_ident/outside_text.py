# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Text from outside (names of files, topics and joints, what others wrote), made fit to be shown."""

import unicodedata

_UNSHOWN = {"Cc", "Cf", "Cs", "Zl", "Zp"}
"""Unicode's categories of characters that command terminals, turn the direction of writing, or are none."""
_NOT_UTF_8 = range(0xDC80, 0xDD00)
"""How Python holds the bytes of a file's name that are not UTF-8."""
LONGEST = 400


def shown(text: object, longest: int = LONGEST) -> str:
    r"""Return a text as one line that is safe in a terminal, a log, a file's name and a page.

    White space becomes one blank; control characters, marks of direction and bytes that are not UTF-8 are written as
    escapes (`\x1b`); of a text that is too long the middle is left out.
    """
    words = str(text)
    if len(words) > 8 * longest:
        words = f"{words[: 4 * longest]} {words[-4 * longest :]}"
    line = "".join(map(_visible, " ".join(words.split())))
    if len(line) > longest:
        head = longest * 2 // 3
        line = f"{line[:head]}…{line[len(line) - (longest - head - 1) :]}"
    return line


def utf_8(text: object) -> str:
    r"""Return a text as ROS can carry it, all of it: bytes that are not UTF-8 are written as escapes (`\udcff`)."""
    return str(text).encode(errors="backslashreplace").decode()


def _visible(character: str) -> str:
    if unicodedata.category(character) not in _UNSHOWN:
        return character
    number = ord(character)
    if number in _NOT_UTF_8:
        number -= 0xDC00
    return f"\\x{number:02x}" if number < 0x100 else f"\\u{number:04x}" if number < 0x10000 else f"\\U{number:08x}"
