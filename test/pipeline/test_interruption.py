# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while an identification runs."""

import signal
import subprocess
import sys

import pytest

from cdp_ident.pipeline.interruption import Interruption


@pytest.fixture
def interruption():
    result = Interruption()
    result.install()
    yield result
    result.remove()


def test_the_first_ctrl_c_asks_the_search_to_stop_and_the_second_ends_the_program(interruption):
    with interruption.identifying():
        assert not interruption.asked
        signal.raise_signal(signal.SIGINT)
        assert interruption.asked
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_where_nothing_is_identified_ctrl_c_ends_the_program(interruption):
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    with interruption.identifying():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_a_request_to_end_asks_the_search_to_stop_and_is_remembered(interruption):
    with interruption.identifying():
        signal.raise_signal(signal.SIGTERM)
        assert interruption.asked
        assert interruption.ends


def test_the_program_ends_by_the_second_request():
    code = """
import signal
from cdp_ident.pipeline.interruption import Interruption
interruption = Interruption()
interruption.install()
with interruption.identifying():
    signal.raise_signal(signal.SIGTERM)
    signal.raise_signal(signal.SIGTERM)
"""
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, timeout=300)
    assert (done.returncode, done.stderr) == (-signal.SIGTERM, b"")


def test_a_search_is_cancelled_only_while_it_runs(interruption):
    with interruption.identifying():
        with interruption.searching():
            assert interruption.cancel()
        interruption.asked = False
        assert not interruption.cancel()
        assert not interruption.asked


def test_each_identification_is_asked_by_itself(interruption):
    with interruption.identifying():
        signal.raise_signal(signal.SIGINT)
    with interruption.identifying():
        assert not interruption.asked


def test_an_ignored_ctrl_c_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        interruption = Interruption()
        interruption.install()
        with interruption.identifying():
            signal.raise_signal(signal.SIGINT)
        assert not interruption.asked
    finally:
        signal.signal(signal.SIGINT, before)
