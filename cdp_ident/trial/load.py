# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a bag to a trial."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from cdp_ident.bag.metadata import Metadata
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.errors import OptionError, OtherMotionError, TrialError
from cdp_ident.model.weights import ADDED, Weight, weights_of
from cdp_ident.outside_text import shown
from cdp_ident.trial.conventions import in_right_ranges
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import select_joints
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.sample_times import in_device_time, in_measured_time
from cdp_ident.trial.trial import Trial


def load_trial(bag: Path, options: TrialOptions | None = None) -> Trial:
    """Load the longest zero-input motion that a bag holds.

    The bag is read (`read_joint_states`), its joints are mapped to theta1 and theta2 (`TrialOptions`), repeated and
    late samples and outliers are dropped, and the angles unwrapped; the conventions of the angles are checked against
    the physics of the motion; parts in which a hand acts, the cart is driven or the rods are at rest are cut.
    `Trial.notes` says what was done. Weights on the rods are those in the bag's metadata. Samples keep the times at
    which they were measured, by the device's own clock where the bag has it (`in_device_time`).

    Raises:
        BagError: the bag cannot be read or holds no joint states on the topic.
        TrialError: joints are missing, the data contradict the conventions, there is no motion long enough, or the
            weights in the bag's metadata are not possible.
    """
    options = options or TrialOptions()
    recording = in_device_time(in_measured_time(read_joint_states(bag, options.topic), options))
    try:
        samples, notes = select_joints(recording, options)
        trial = find_trial(in_right_ranges(samples, options), options).trial
    except TrialError as error:
        there = [f"joints: {shown(', '.join(recording.joints))}"] if isinstance(error, OtherMotionError) else []
        raise TrialError("; ".join([f"{shown(bag)}: {error}", *there, *recording.notes])) from error
    weights, weight_notes = _recorded_weights(bag)
    said = (*recording.notes, *weight_notes, *notes, *trial.notes)
    return replace(trial, name=recording.name, notes=said, clock=recording.device_rate or trial.clock, weights=weights)


def _recorded_weights(bag: Path) -> tuple[tuple[Weight, ...], list[str]]:
    """Return the weights that the recorder wrote into a bag's metadata, and what casts doubt on that, in words.

    Raises TrialError where they are not possible.
    """
    metadata = Metadata.of(bag)
    notes = [metadata.problem] if metadata.problem else []
    if "salvaged" in metadata.custom_data:
        notes.append(
            "the recorder was killed: whether weights were on the rods is not known; trials.<bag>.added tells it"
        )
    try:
        given = json.loads(metadata.custom_data.get(ADDED) or "{}")
    except (ValueError, RecursionError) as error:
        raise TrialError(f"{bag}: '{ADDED}' in its metadata is not JSON: {error}") from error
    if not isinstance(given, Mapping):
        raise TrialError(f"{bag}: '{ADDED}' in its metadata must name weights by rod")
    try:
        found = weights_of(given, f"{bag}: metadata")
    except OptionError as error:
        raise TrialError(str(error)) from error
    return tuple(weight for weight in found.values() if weight), notes
