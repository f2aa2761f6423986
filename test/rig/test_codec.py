# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both codecs: what survives the way there and back, and what is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.rig.decoder import LONGEST_FRAME
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, FrameError, Hello, Sample, TextCodec, checksum

CODECS = [BinaryCodec(), TextCodec()]
UNSIGNED = st.integers(0, 2**32 - 1)
POSITIVE = st.integers(1, 2**32 - 1)
SIGNED = st.integers(-(2**31), 2**31 - 1)
SAMPLES = st.builds(Sample, UNSIGNED, UNSIGNED, SIGNED, SIGNED, SIGNED, st.integers(0, 255))
FIRMWARE = st.text(st.sampled_from([chr(code) for code in range(32, 127) if chr(code) not in ",*"]), max_size=32)
HELLOS = st.builds(Hello, POSITIVE, POSITIVE, POSITIVE, FIRMWARE)
RECORDS = SAMPLES | HELLOS | st.builds(CartCommand, UNSIGNED, SIGNED)


def test_the_checksum_is_the_documented_one():
    assert checksum(b"123456789") == 0x29B1


@pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.name)
@given(record=RECORDS)
def test_every_record_survives_the_way_there_and_back(codec, record):
    frame = codec.encode(record)
    assert frame.endswith(codec.delimiter)
    assert codec.delimiter not in frame[:-1]
    assert len(frame) <= LONGEST_FRAME
    assert codec.decode(frame[:-1]) == record


@pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.name)
@given(frame=st.binary(max_size=200))
def test_arbitrary_bytes_are_a_frame_error_or_a_record(codec, frame):
    try:
        codec.decode(frame)
    except FrameError:
        return


@pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.name)
@given(record=RECORDS, data=st.data())
def test_one_flipped_bit_of_the_text_and_of_a_frame_without_zeros_never_passes(codec, record, data):
    frame = bytearray(codec.encode(record)[:-1])
    place = data.draw(st.integers(0, len(frame) * 8 - 1))
    frame[place // 8] ^= 1 << place % 8
    try:
        assert codec.decode(bytes(frame)) == record  # as where a hexadecimal digit only changed its case
    except FrameError:
        return


@pytest.mark.parametrize(
    "line",
    [
        b"S1,7,1000000,0,-2,4000,256",
        b"S1,-7,1000000,0,-2,4000,0",
        b"S1,4294967296,1000000,0,-2,4000,0",
        b"S1,7,1000000,2147483648,-2,4000,0",
        b"S1,7,1000000,0,-2,4000",
        b"S1,7,1000000,0,-2,4000,0,0",
        b"S1,7,1000000,0,--2,4000,0",
        b"S1,7,1000000,0,,4000,0",
        b"S2,7,1000000,0,-2,4000,0",
        b"X1,7,1000000,0,-2,4000,0",
        b"H1,0,8000,8000,rig",
        b"C1,7",
        b"C1,-7,100",
        b"C1,7,2147483648",
        b"H1,1000,8000,8000," + b"x" * 33,
    ],
)
def test_a_line_with_a_right_checksum_but_wrong_fields_is_refused(line):
    with pytest.raises(FrameError) as caught:
        TextCodec().decode(b"$%s*%04X\r" % (line, checksum(line)))
    assert caught.type is FrameError
