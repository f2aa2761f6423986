# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The serial protocol: what survives the way there and back, what is refused, and what the document says of it."""

import math
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.rig.decoder import LONGEST_FRAME, Decoder
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Commands, FrameError, Hello, Sample, TextCodec, checksum

UNSIGNED = st.integers(0, 2**32 - 1)
POSITIVE = st.integers(1, 2**32 - 1)
SIGNED = st.integers(-(2**31), 2**31 - 1)
SAMPLES = st.builds(Sample, UNSIGNED, UNSIGNED, SIGNED, SIGNED, SIGNED, st.integers(0, 255))
FIRMWARE = st.text(st.sampled_from([chr(code) for code in range(32, 127) if chr(code) not in ",*"]), max_size=32)
HELLOS = st.builds(Hello, POSITIVE, POSITIVE, POSITIVE, FIRMWARE)
RECORDS = SAMPLES | HELLOS | st.builds(CartCommand, UNSIGNED, SIGNED)


def test_the_checksum_is_the_documented_one():
    assert checksum(b"123456789") == 0x29B1


@given(record=RECORDS)
def test_every_record_survives_the_way_there_and_back(codec, record):
    frame = codec.encode(record)
    assert frame.endswith(codec.delimiter)
    assert codec.delimiter not in frame[:-1]
    assert len(frame) <= LONGEST_FRAME
    assert codec.decode(frame[:-1]) == record


@given(frame=st.binary(max_size=200))
def test_arbitrary_bytes_are_a_frame_error_or_a_record(codec, frame):
    try:
        codec.decode(frame)
    except FrameError:
        return


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


def decoded(frame):
    return BinaryCodec().decode(frame.removesuffix(b"\0"))


def test_each_command_has_the_next_number_and_the_counter_s_direction():
    commands = Commands(BinaryCodec(), -1)
    assert decoded(commands.frame(1.5)) == CartCommand(1, -1500)
    assert decoded(commands.frame(-0.0004)) == CartCommand(2, 0)


@pytest.mark.parametrize("acceleration", [1e300, 2147484.0])
def test_a_command_larger_than_its_field_is_the_largest(acceleration):
    commands = Commands(BinaryCodec(), 1)
    assert decoded(commands.frame(acceleration)) == CartCommand(1, 2**31 - 1)
    assert decoded(commands.frame(-acceleration)) == CartCommand(2, 1 - 2**31)


@pytest.mark.parametrize("acceleration", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_never_sent(acceleration):
    assert Commands(BinaryCodec(), 1).frame(acceleration) == b""


DOCUMENT = (Path(__file__).parents[2] / "docs" / "reference" / "protocol.md").read_text(encoding="utf-8")
SAMPLE = Sample(7, 1_000_000, 0, -2, 4000, 0)
HELLO = Hello(1000, 8000, 8000, "rig 1.0")
COMMAND = CartCommand(7, -1500)

BOARD = r"""
#include <cstdint>
#include <cstdio>
static uint32_t now = 4294957296u;  // soon rolls over
uint32_t micros() { return now += 100; }
void noInterrupts() {}
void interrupts() {}
struct {
  void begin(long) {}
  void print(char c) { putchar(c); }
  void print(const char *s) { fputs(s, stdout); }
  void println(const char *s) { printf("%s\r\n", s); }
} Serial;
#define sprintf(text, ...) snprintf(text, sizeof(text), __VA_ARGS__)
"""
RUN = r"""
int main() {
  setup();
  cart = 5; inner = -2147483647; outer = 12;
  for (int i = 0; i < 30000; i++) loop();
}
"""


@pytest.mark.parametrize("record", [SAMPLE, HELLO, COMMAND])
def test_the_document_shows_the_frames_that_the_codecs_write(record):
    assert f"    {BinaryCodec().encode(record).hex(' ')}\n" in DOCUMENT
    assert f"    {TextCodec().encode(record).decode().strip()}\n" in DOCUMENT


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler here")
def test_the_documents_sketch_is_understood_by_the_decoder(tmp_path):
    sketch = DOCUMENT.partition("```c++\n")[2].partition("```")[0]
    (tmp_path / "rig.cpp").write_text(BOARD + sketch.replace("%lu", "%u").replace("%ld", "%d") + RUN)
    subprocess.run(["g++", "-o", tmp_path / "rig", tmp_path / "rig.cpp"], check=True)
    sent = subprocess.run([tmp_path / "rig"], check=True, stdout=subprocess.PIPE).stdout
    decoder = Decoder(TextCodec())
    events = decoder.feed(sent)
    samples = [event for event in events if isinstance(event, Sample)]
    assert events[0] == Hello(5000, 8000, 8000, "sketch 1.0")
    assert [sample.sequence for sample in samples] == list(range(len(samples)))
    assert len(samples) > 500
    assert (samples[0].cart, samples[0].inner, samples[0].outer) == (5, -2147483647, 12)
    assert decoder.counters.lost + decoder.counters.malformed + decoder.counters.bad_checksum == 0
