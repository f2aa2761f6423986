# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The zero's file."""

import pytest

from cdp_ident.errors import RigError
from cdp_ident.rig.zero import Zero, load_zero, save_zero

ZERO = Zero((1.5, -2.25, 1e9), 4_000_000_000, 1_760_000_000_000_000_000)


def test_a_zero_is_kept(tmp_path):
    path = tmp_path / "new" / "zero.yaml"
    save_zero(path, Zero((0.0, 0.0, 0.0), 1, 2))
    save_zero(path, ZERO)
    assert load_zero(path) == ZERO
    assert list(path.parent.iterdir()) == [path]


def test_no_file_is_no_zero(tmp_path):
    assert load_zero(tmp_path / "zero.yaml") is None


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"[1, 2]",
        b"cart_counts: 1\n",
        b"{cart_counts: x, inner_counts: 0, outer_counts: 0, sequence: 0, taken_at_ns: 0}",
        b"{cart_counts: .nan, inner_counts: 0, outer_counts: 0, sequence: 0, taken_at_ns: 0}",
    ],
)
def test_a_damaged_file_is_refused_with_what_to_do(tmp_path, content):
    path = tmp_path / "zero.yaml"
    path.write_bytes(content)
    with pytest.raises(RigError, match=r"(?s)zero\.yaml.*delete it"):
        load_zero(path)


def test_a_place_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RigError, match="cannot be kept"):
        save_zero(tmp_path / "file" / "zero.yaml", ZERO)


@pytest.mark.parametrize(
    ("sequence", "seconds", "same"),
    [
        (4_000_000_000, 0.0, True),
        (4_000_060_000, 60.0, True),
        ((4_000_000_000 + 86_400_000) % 2**32, 86_400.2, True),
        ((4_000_000_000 + 864_000_000) % 2**32, 864_000.0, True),
        (100, 60.0, False),
        (0, 1.0, False),
        (4_000_060_000, 600.0, False),
        (4_000_060_000, -60.0, False),
    ],
)
def test_the_sequence_number_tells_whether_the_device_ran_on(sequence, seconds, same):
    assert ZERO.is_of_this_run(sequence, ZERO.taken_at_ns + round(seconds * 1e9), 1000) is same
