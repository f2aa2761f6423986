"""How the laws of torques are compiled for motions side by side; what they give is compared in `test_trajectories`."""

import re

import numpy as np
import pytest

from cdp_ident.model.compilation import compiled, part
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Form
from cdp_ident.model.lane_rows import LANES, MOTION
from cdp_ident.model.torques_in_lanes import loop_of_joint_law, loop_of_rods_law

BY_KEY = {effect.key: effect for effect in CATALOGUE}


@pytest.mark.parametrize(
    "key", ["coulomb_friction.inner", "joint_spring.inner", "air_drag.inner", "load_friction.outer"]
)
def test_a_law_s_loop_is_made_of_vector_instructions(key, monkeypatch):
    effect = BY_KEY[key]
    loop_of = loop_of_rods_law if effect.form is Form.RODS else loop_of_joint_law
    add = part(loop_of(effect.law, effect.dry))

    def law_in_lanes(motion, joint, width):
        add(motion, joint, 0.5, width)

    monkeypatch.setattr("cdp_ident.model.compilation._CACHE_FOLDER", None)  # what is kept cannot be looked at
    loop = compiled(law_in_lanes)
    loop(np.ones(MOTION * LANES), 0, np.uint64(LANES))
    (code,) = loop.inspect_llvm().values()
    assert re.search(r"load <\d+ x double>", code)
    assert re.search(r"store <\d+ x double>", code)
