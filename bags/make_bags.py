"""Make the example bags anew: `PYTHONPATH=. python3 bags/make_bags.py FOLDER`.

They are recordings of a simulated rig, as README.md beside this file says.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.model.parameters import NOMINAL, SYMBOLS, physical_coefficients
from cdp_ident.rig.emulator.motion import Motion
from cdp_ident.rig.emulator.script import Hold, LetGo, Wait

# The last row of the paper's Table 5: what its authors found on their rig, other than the nominal values of Table 2.
TRUTH = NOMINAL | dict(
    zip(SYMBOLS, (0.1296, 0.1154, 0.2192, 0.2007, 0.1691, 0.0007, 0.0016, 0.0049, 0.0006), strict=True)
)
RATE = 200
COUNTS_PER_TURN = 8000
STARTS = {"swing_wide": (2.2, 2.0), "swing_folded": (2.4, 4.5), "swing_check": (4.0, 4.4)}
"""Where the hand lets go: theta1, theta2 [rad] from upright. The rods swing wide but not over the top."""
FREE_SECONDS = 14.0
FIRST_STAMP = 1_717_156_800_000_000_000


def positions(start: tuple[float, float]) -> npt.NDArray[np.float64]:
    """Return what the encoders measure (n, 3): cart [m], inner joint, and outer joint relative to it [rad]."""
    script = (Wait(1.0), Hold(*start, within=1.5), Wait(1.5), LetGo(), Wait(FREE_SECONDS))
    seconds = 4.0 + FREE_SECONDS
    cart, theta1, theta2 = Motion(physical_coefficients(TRUTH), script, 1 / RATE).advance(round(seconds * RATE)).T
    joints = np.column_stack([theta1, theta2 - theta1])
    count = math.tau / COUNTS_PER_TURN
    return np.column_stack([cart, np.round(joints / count) * count])


def write(bag: Path, start: tuple[float, float]) -> None:
    """Write one bag."""
    names = ("cart_joint", "inner_joint", "outer_joint")
    with BagWriter(bag) as writer:
        for i, measured in enumerate(positions(start)):
            stamp = FIRST_STAMP + i * 1_000_000_000 // RATE
            writer.write("/joint_states", MESSAGE_TYPE, stamp, serialize_joint_state(names, measured, stamp))
        writer.close(
            {
                "rig": "simulated, 200 Hz, 8000 counts a turn; bags/README.md",
                "let_go_at_rad": json.dumps(start),
                "truth": json.dumps(TRUTH),
            }
        )


if __name__ == "__main__":
    for name, start in STARTS.items():
        write(Path(sys.argv[1]) / name, start)
