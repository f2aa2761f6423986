"""Ctrl-C while a search runs."""

import signal

import pytest

from cdp_ident.pipeline.interruption import Interruption


@pytest.fixture
def interruption():
    result = Interruption()
    result.install()
    yield result
    result.remove()


def test_the_first_ctrl_c_asks_the_search_to_stop_and_the_second_ends_the_program(interruption):
    with interruption.searching():
        assert not interruption.asked
        signal.raise_signal(signal.SIGINT)
        assert interruption.asked
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_without_a_search_ctrl_c_ends_the_program(interruption):
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    with interruption.searching():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_each_search_is_asked_by_itself(interruption):
    with interruption.searching():
        signal.raise_signal(signal.SIGINT)
    with interruption.searching():
        assert not interruption.asked


def test_an_ignored_ctrl_c_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        interruption = Interruption()
        interruption.install()
        with interruption.searching():
            signal.raise_signal(signal.SIGINT)
        assert not interruption.asked
    finally:
        signal.signal(signal.SIGINT, before)
