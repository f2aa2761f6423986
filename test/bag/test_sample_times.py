"""Stamps are believed unless they tell nothing where the times of receipt do."""

import numpy as np
import pytest

from cdp_ident.bag.sample_times import sample_times

STAMPS = 1_700_000_000_200_000_000 + 5_000_000 * np.arange(2000)
RECEIPTS = STAMPS + 300_000 + np.random.default_rng(1).integers(0, 200_000, 2000)


@pytest.mark.parametrize(
    ("stamps", "fault"),
    [
        (STAMPS // 10**9 * 10**9, "are whole seconds"),
        (STAMPS // 10**9 * 10**9 + STAMPS % 10**9 // 1000, "hold microseconds where nanoseconds belong"),
        (STAMPS // 10**9 * 10**9 + STAMPS % 10**9 // 10**6, "hold milliseconds where nanoseconds belong"),
        (np.full(2000, STAMPS[0]), "are not the times of the samples (1 different ones"),
        ((np.float32((STAMPS - STAMPS[0]) / 1e9 + 1e5).astype(float) * 1e9).astype(np.int64), "are not the times"),
        (np.zeros(2000, dtype=np.int64), "are missing"),
    ],
)
def test_useless_stamps_give_way_to_the_times_of_receipt_unless_they_are_asked_for(stamps, fault):
    times, kept, (note,) = sample_times(stamps, RECEIPTS, "auto")
    assert np.array_equal(times[kept], RECEIPTS)
    assert f"the stamps {fault}" in note
    assert np.array_equal(sample_times(stamps, RECEIPTS, "stamps")[0], stamps)


@pytest.mark.parametrize(
    ("stamps", "receipts"),
    [
        (STAMPS, RECEIPTS),
        (STAMPS, STAMPS // 50_000_000 * 50_000_000),
        (STAMPS + np.where(np.arange(2000) < 900, 10**11, 0), RECEIPTS),
        (np.repeat(STAMPS[:1000], 2), np.sort(np.concatenate([RECEIPTS[:1000], RECEIPTS[:1000] + 300]))),
        (STAMPS, STAMPS[0] + np.arange(2000)),
        (np.random.default_rng(2).permutation(STAMPS), RECEIPTS),
        (STAMPS, np.full(2000, STAMPS[0])),
    ],
    ids=[
        "good",
        "received in batches",
        "clock set back",
        "two messages each",
        "copied at once",
        "shuffled",
        "no receipt",
    ],
)
def test_good_stamps_are_used_whatever_the_times_of_receipt_are(stamps, receipts):
    times, kept, notes = sample_times(stamps, receipts, "auto")
    assert np.array_equal(times[kept], stamps)
    assert notes == []
    assert np.array_equal(sample_times(stamps, receipts, "receipt")[0], receipts)
