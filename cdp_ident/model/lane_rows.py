"""Where everything is of several motions that are side by side in lanes.

What belongs to the motions is in rows of one number for each, in three arrays: of the motion itself, of the stages of a
step, and of the derivatives in pairs, one row for each rod. Within one array the compiler knows how far those rows are
from each other that a loop is about: only so does it see that they do not overlap, and vectorises the loops over lanes.
For the same reason indices are unsigned, for a negative one would count from the array's end, and the loops are handed
their length, though it is always `LANES`: those whose length is known are unrolled before they would be vectorised.
"""

import numpy as np

from cdp_ident.model.compilation import inlined
from cdp_ident.model.effects.constants import COUNT
from cdp_ident.model.effects.effect import MOST_OF_A_LAW
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.parameters import COEFFICIENTS

LANES = 8
"""Motions side by side: as many as fit into the widest vector register."""
_COEFFICIENTS = len(COEFFICIENTS)
BEFORE_PARAMETERS = RODS_STATES + _COEFFICIENTS
"""Directions before those of effects' parameters."""
MOST_PARAMETERS, MOST_EFFECTS = 13, 16
"""Directions of effects' parameters, and effects, that there is room for."""
_PAIRS = 2 * (BEFORE_PARAMETERS + MOST_PARAMETERS)
"""Rows of one number for each rod and each direction: the initial state, the coefficients, effects' parameters."""

# Rows of a motion: where each kind begins.
OF_COEFFICIENTS = 0
LENGTH = OF_COEFFICIENTS + _COEFFICIENTS
"""The step's length [s]."""
ROUGHNESS = LENGTH + 1
"""The largest difference between the rates at the last stage and at the end: see `is_too_rough`."""
WEIGHTS = ROUGHNESS + 1
"""Weights of a Hermite polynomial by which a measurement is read."""
STATE = WEIGHTS + 4
"""The state at the step's beginning."""
HERE = STATE + RODS_STATES
"""The state at a stage, and then at the step's end."""
# What follows is used where effects act.
TIME = HERE + RODS_STATES
"""Time in the trial at the step's beginning [s]."""
MODES = TIME + 1
"""What the inner and the outer joint do: see `dynamics`."""
LOOKS = MODES + 2
"""Whether a joint's mode may have ended within the step: above zero if so."""
TURNED = LOOKS + 1
"""Both angles' sines and cosines at a stage."""
TORQUES = TURNED + 4
"""The effects' torques on both rods there."""
SIZES = TORQUES + 2
"""Sizes of the dry friction in the inner and the outer joint."""
COUPLED = SIZES + 2
"""What they add to the inertia between the rods."""
BY_STATE = COUPLED + 1
"""The torques' derivatives by the state: those of the first one, then of the second one."""
BY_COEFFICIENTS = BY_STATE + 2 * RODS_STATES
"""Likewise by the coefficients."""
BY_PARAMETERS = BY_COEFFICIENTS + 2 * _COEFFICIENTS
"""One effect's torques' derivatives by its parameters: those of the first one, then of the second one."""
ACTING = BY_PARAMETERS + 2 * MOST_OF_A_LAW
"""Its parameters: which of the rows below they are in, the compiler does not know."""
SIZE = ACTING + MOST_OF_A_LAW
"""If it is dry friction, its size, and what the joint does: see `dynamics`."""
MODE = SIZE + 1
RESPONSE = MODE + 1
"""The rods' response to torques."""
CONSTANTS = RESPONSE + 4
"""What laws know of the mechanism."""
VALUES = CONSTANTS + COUNT
"""Of each effect its parameters."""
MOTION = VALUES + MOST_OF_A_LAW * MOST_EFFECTS
"""How many rows a motion has."""

# Rows of a stage.
INPUT = 0
"""The cart's acceleration."""
RATES = INPUT + 1
"""The state's rates."""
MATRIX = RATES + RODS_STATES
"""The derivatives of the accelerations by the state."""
DIRECT = MATRIX + 2 * RODS_STATES
"""Those by the directions themselves, zero for the initial state."""
STAGE = DIRECT + _PAIRS
"""How many rows a stage has."""

# Rows of the derivatives.
ANGLES, SPEEDS, SLOPES = 0, _PAIRS, 2 * _PAIRS
"""The derivatives of the angles, of the speeds, and the rates of these."""
TANGENTS = 3 * _PAIRS
"""How many rows the derivatives have."""

READING = RODS_STATES + _PAIRS
"""Rows of a measurement: the state, and the derivatives of both angles by each direction."""


@inlined
def row(number):
    """Return the index of a row's first lane."""
    return np.uint64(LANES) * np.uint64(number)
