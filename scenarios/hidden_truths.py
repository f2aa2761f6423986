# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hidden truths of rigs of the paper's size whose dry friction is smooth, as trials of the package."""

from cdp_ident.trial.trial import Trial
from reference import hidden_truths
from reference.hidden_truths import FIT_TRIALS, Answer

__all__ = ["FIT_TRIALS", "Answer", "hidden_truth"]


def hidden_truth(kind: str, seed: int, visible: float | None = None) -> tuple[list[Trial], Answer]:
    """Return three trials, the last one to be held out, and the answer sheet; see `reference.hidden_truths`."""
    measured, answer = hidden_truths.hidden_truth(kind, seed, visible)
    return [Trial(trial.name, trial.time, trial.theta) for trial in measured], answer
