"""From a bag to a trial."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.cleaning import Piece, clean
from cdp_ident.trial.conventions import check_conventions
from cdp_ident.trial.joints import Samples, model_angles, select_joints
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.trial import Trial
from cdp_ident.trial.zero_input import choose_part, find_parts, moving_windows

_FEWEST_SAMPLES = 20
"""Samples [1/s] below which velocities of a swing cannot be estimated."""


def load_trial(bag: Path, options: TrialOptions | None = None) -> Trial:
    """Load the longest zero-input motion that a bag holds.

    The bag is read (`read_joint_states`), its joints are mapped to theta1 and theta2 (`TrialOptions`), repeated and
    late samples are dropped, and the angles unwrapped; what was taken for granted about the angles is checked against
    the physics of the motion; the hand's holding and pushing, the cart's driving and the rest at the end are cut. What
    was done stands in `Trial.notes`. Samples keep the times at which they were measured.

    Raises:
        BagError: the bag cannot be read or holds no joint states on the topic.
        TrialError: joints are missing, the data contradict the conventions, or there is no motion long enough.
    """
    options = options or TrialOptions()
    recording = read_joint_states(bag, options.topic)
    try:
        samples, notes = select_joints(recording, options)
        trial = _zero_input(samples, options)
    except TrialError as error:
        raise TrialError(f"{bag}: {error}") from error
    return replace(trial, name=recording.name, notes=(*recording.notes, *notes, *trial.notes))


def _zero_input(samples: Samples, options: TrialOptions) -> Trial:
    pieces, notes = clean(_between(samples, options.start, options.stop), options.longest_gap, samples.stamps[0])
    pieces = [piece for piece in pieces if _is_long_enough(piece, options.shortest)]
    if not pieces:
        length = (samples.stamps[-1] - samples.stamps[0]) * 1e-9
        rules = f"at least {_FEWEST_SAMPLES} samples a second and no gap over {options.longest_gap} s"
        raise TrialError(
            f"{len(samples.stamps)} samples over {length:.2f} s hold no stretch of {options.shortest} s with "
            f"{rules}; {'; '.join(notes) or 'the bag is too short'}"
        )
    motions = [motion_on_grid(piece.time, piece.angles, piece.cart) for piece in pieces]
    moving = [moving_windows(motion, options) for motion in motions]
    balance, warnings = check_conventions(motions, moving, options)
    parts, knocks = find_parts(motions, balance, options)
    part, cuts = choose_part(parts, options.shortest)
    piece = pieces[part.motion]
    chosen = (piece.time >= part.start) & (piece.time <= part.stop)
    time = piece.time[chosen]
    return Trial(
        name="",
        time=time - time[0],
        theta=model_angles(piece.angles[chosen], options),
        cart=None if piece.cart is None else options.cart_sign * piece.cart[chosen],
        start=float(time[0]),
        notes=(*notes, *warnings, *cuts, *knocks),
    )


def _between(samples: Samples, start: float, stop: float) -> Samples:
    """Return the samples from `start` to `stop` [s] after the first."""
    time = (samples.stamps - samples.stamps[0]) * 1e-9
    chosen = (time >= start) & (time <= stop)
    if not np.any(chosen):
        raise TrialError(f"no sample lies between start {start} s and stop {stop} s: the bag has {time[-1]:.2f} s")
    cart = None if samples.cart is None else samples.cart[chosen]
    return Samples(samples.stamps[chosen], samples.angles[chosen], cart)


def _is_long_enough(piece: Piece, shortest: float) -> bool:
    duration = piece.time[-1] - piece.time[0]
    return bool(duration >= shortest and len(piece.time) >= _FEWEST_SAMPLES * duration)
