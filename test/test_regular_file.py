# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Only regular files are read, and only up to a size."""

import os

import pytest

from cdp_ident.regular_file import open_regular, read_regular


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/tty", "/proc/self", "a\0b"])
def test_what_is_no_regular_file_is_refused(path):
    with pytest.raises(OSError, match=r"regular file|null byte|No such device"):
        open_regular(path)


def test_a_pipe_that_nobody_writes_to_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="not a regular file"):
        open_regular(tmp_path / "pipe")


def test_a_file_is_read_up_to_its_limit(tmp_path):
    (tmp_path / "file").write_bytes(b"12345")
    assert read_regular(tmp_path / "file", 5) == b"12345"
    with pytest.raises(OSError, match="larger than 4 bytes"):
        read_regular(tmp_path / "file", 4)
