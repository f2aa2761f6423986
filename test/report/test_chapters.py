"""A report as a document."""

import pytest

from cdp_ident.report.chapters import document_of


@pytest.mark.parametrize(
    ("names", "heading"),
    [
        (["swing_wide", "trial_20261126_093000"], "swing_wide, trial_20261126_093000"),
        (["trial_20261126_093000"], "1 trial of 2026-11-26"),
        (
            ["trial_20261126_093000", "a_20261125_093000", "trial_20261126_093000_2"],
            "3 trials of 2026-11-25, 2026-11-26",
        ),
    ],
)
def test_a_report_is_called_by_its_trials_and_not_by_time_stamps(read_content, names, heading):
    (some, *_) = read_content["trials"]
    read_content["trials"] = [{**some, "role": "fit", "name": name} for name in names]
    assert document_of(read_content).heading == heading
