# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""docs/reference/protocol.md: its frames are those that the codecs speak, and its sketch compiles and is understood."""

import shutil
import subprocess
from pathlib import Path

import pytest

from cdp_ident.rig.decoder import Decoder
from cdp_ident.rig.protocol import BinaryCodec, CartCommand, Hello, Sample, TextCodec

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
