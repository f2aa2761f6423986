"""What encoders show of a motion, and its derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.model.effects.bending import Load
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.effects.readings import encoder_readings

LATE = next(effect for effect in CATALOGUE if effect.key == "time_offset.outer")
TIME = np.linspace(0.0, 3.0, 50)
RATES = np.array([2.0, -3.0])
LOAD = Load(0.3, 9.81, lambda states, delay: (np.zeros((len(states), 2)), np.zeros(len(states))))


def motion(delay):
    """Return rods that swing evenly, and no derivatives but by an unknown that the delay is."""
    phase = RATES * (TIME[:, None] - delay)
    states = np.concatenate([np.sin(phase), RATES * np.cos(phase)], axis=1)
    return states, np.zeros((len(TIME), 4, 1))


@pytest.mark.parametrize("joint", JOINTS)
def test_either_encoder_may_be_late(joint):
    def shown(delay):
        return encoder_readings(motion, [(replace(LATE, joint=joint), [delay], slice(0, 1))], TIME, 0, LOAD)

    angles, by_delay = shown(0.02)
    now, then = motion(0.0)[0], motion(0.02)[0]
    inner, outer = (then, now) if joint == "inner" else (now, then)
    expected = np.stack([inner[:, 0], inner[:, 0] + outer[:, 1] - outer[:, 0]], axis=1)
    assert angles == pytest.approx(expected, abs=1e-12)
    differences = (shown(0.02 + 1e-6)[0] - shown(0.02 - 1e-6)[0]) / 2e-6
    assert by_delay[..., 0] == pytest.approx(differences, abs=1e-6)
