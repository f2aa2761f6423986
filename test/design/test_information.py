"""What windows show of values, beside what their own initial states imitate."""

from dataclasses import replace

import numpy as np

from cdp_ident.design.information import reduced_sensitivities, scaled_inverse
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import standard_twin

MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])


def test_a_window_s_own_start_imitates_a_part_of_what_the_values_do():
    windows = cut_into_windows([standard_twin(np.random.default_rng(0))])
    fit = refine(MODEL, TRUTH, windows)
    for sensitivity, reduced in zip(fit.sensitivities, reduced_sensitivities(fit), strict=True):
        assert (
            np.abs(np.einsum("nrs,nrp->sp", sensitivity[..., :4], reduced)).max()
            < 1e-6 * np.abs(sensitivity).max() ** 2
        )
    known = refine(MODEL, TRUTH, [replace(windows[0], start=np.array(TABLE_3), start_known=True)])
    assert np.array_equal(next(reduced_sensitivities(known)), known.sensitivities[0][..., 4:])


def test_what_has_no_unknowns_has_an_inverse_of_none():
    inverse, left_out = scaled_inverse(np.empty((0, 0)), 1e-12)
    assert inverse.shape == left_out.shape == (0, 0)
