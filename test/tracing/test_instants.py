"""What is said of an instant before anything is refitted."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.reweighting import reweighted
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing import instants
from scenarios.hidden_truths import hidden_truth


@pytest.fixture(scope="module")
def chaotic() -> Fit:
    trials, _ = hidden_truth("impulse.inner", 8000)
    return reweighted(identify(trials, [], IdentifyOptions()).fit, np.inf)


@pytest.mark.parametrize("column", [0, 1])
def test_an_impulse_s_gain_is_that_of_its_projection_even_where_motion_is_chaotic(chaotic, column, monkeypatch):
    scanned = []

    def gains(fit, window, size, fitting):
        scanned.append((window, size, fitting))
        return instants._Instant(0.0, 0.0, 0, 0.0)

    monkeypatch.setattr(instants, "_best", gains)
    effect = next(e for e in CATALOGUE if e.key == ("impulse.inner", "impulse.outer")[column])
    motions = [instants._Motion.of(chaotic, window) for window in chaotic.windows]
    instants._scan_impulses(chaotic, effect, motions)
    for (window, size, fitting), residual, motion in zip(scanned, chaotic.residuals, motions, strict=True):
        states, transition, basis = motion.states, motion.transition, motion.basis
        start = basis.reshape(-1, 4)
        for j in (20, len(states) // 2, len(states) - 20):
            change = instants._speed_change(chaotic, window, states, column)[j]
            moved = np.where(np.arange(len(states))[:, None] >= j, basis @ np.linalg.solve(transition[j], change), 0.0)
            left = moved.ravel()
            for _ in range(2):
                left = left - start @ (start.T @ left)
            assert size[j] == pytest.approx(left @ left, rel=1e-6)
            assert fitting[j] == pytest.approx(left @ residual.ravel(), rel=1e-6, abs=1e-9 * np.sqrt(size[j]))


def test_an_encoder_s_slip_is_found_at_its_instant(chaotic):
    window = chaotic.windows[1]
    instant = window.time[len(window.time) // 2]
    after = window.time >= instant
    slipped = window.whitening @ [0.0, 0.05]
    residuals = list(chaotic.residuals)
    residuals[1] = residuals[1] + np.where(after[:, None], slipped, 0.0)
    later = [w.trial == window.trial and w.begin > window.begin for w in chaotic.windows]
    residuals = [r + slipped * is_later for r, is_later in zip(residuals, later, strict=True)]
    fit = replace(chaotic, residuals=tuple(residuals))
    slip = next(c for c in instants.instants(fit) if c.active.effect.key == "encoder_slip.outer")
    assert slip.active.trial == window.trial
    assert slip.values == pytest.approx([0.05, window.begin + instant], abs=0.011)
