# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether the encoders' counts per turn are what they are taken for, by the balance of forces with the lengths known.

`trial.encoder_scale` tells the principle; it looks at one recording, whose lengths are not known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.force_balance import CLEARLY_BETTER, DRY, NOT_DRY, ForceBalance, Pieces, balance_of_forces
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import JOINTS, Effect, Law
from cdp_ident.trial.encoder_scale import Joints, least_misfit, refine

_WELL_BALANCED = 0.03
"""Unexplained share of gravity's torque up to which no factor is looked for."""
_BESIDE_NOISE = 2.0
"""The same, over the share of noise."""
_LARGEST_LEFT, _HALF = 0.1, 0.5
"""The unexplained share that a right factor leaves at most, and the same over what is left without it."""
_NEAREST = 0.01
"""Factors nearer to one may imitate a zero that is off, after some turns; the selection of effects tells them apart."""
_CHANGE = 0.003
"""Change of the factor's logarithm by which the misfit's curvature is taken."""
_OF_SCALE = Law(reading="scale*angle")
_SCALES: Mapping[str, Effect] = {effect.joint: effect for effect in CATALOGUE if effect.law == _OF_SCALE}


@dataclass(frozen=True)
class EncoderScale:
    """A factor by which encoders show more than their joints turn."""

    joints: Joints
    """Whose encoders."""
    factor: float
    """Readings over angles."""
    std: float
    balance: ForceBalance
    """With the angles put right."""

    @property
    def failure(self) -> str:
        """Why a fit fails, in words; empty where the factor is within the limits of an effect of the rig."""
        limits = [_SCALES[joint].parameters[0] for joint in self.joints]
        if all(parameter.lower < self.factor - 1.0 < parameter.upper for parameter in limits):
            return ""
        whose = f"the {self.joints[0]} encoder shows" if len(self.joints) == 1 else "both encoders show"
        settings = ", ".join(f"{joint}_scale: {self.factor:.4g}" for joint in self.joints)
        return (
            f"the fit failed: by the balance of forces {whose} {self.factor:.4g} ± {self.std:.1g} times the angle. "
            f"Check the counts per turn; for what is recorded already, set trial: {{{settings}}}"
        )


def encoder_scale(pieces: Pieces, balances: Sequence[ForceBalance]) -> EncoderScale | None:
    """Look for a factor with which forces balance that do not balance without; None where there is none.

    Args:
        pieces: the motion, by the readings.
        balances: of the readings as they are, the most likely first.
    """
    given = balances[0]
    balances_well = np.all(given.unexplained <= np.maximum(_WELL_BALANCED, _BESIDE_NOISE * given.noise_share))
    if balances_well and not any(effect in NOT_DRY for effect in given.effects):
        return None
    _, joints, near = least_misfit(lambda joints, logarithm: _misfit(_turned(pieces, joints, logarithm, ())))

    def closely(logarithm: float) -> ForceBalance | None:
        return _turned(pieces, joints, logarithm, DRY)

    _, _, logarithm = refine(lambda _, at: _misfit(closely(at)), joints, near)
    factor = float(np.exp(logarithm))
    found = closely(logarithm) if abs(factor - 1.0) > _NEAREST else None
    if found is None or found.misfit > min(other.misfit for other in balances) - CLEARLY_BETTER:
        return None
    if found.beyond_noise.max() > min(_LARGEST_LEFT, _HALF * min(other.beyond_noise.max() for other in balances)):
        return None
    below, least, above = (_misfit(closely(logarithm + change)) for change in (-_CHANGE, 0.0, _CHANGE))
    # Minus twice the logarithm of the likelihood: its second derivative is two over the variance.
    curvature = (below - 2.0 * least + above) / _CHANGE**2
    std = float(np.sqrt(2.0 / curvature)) if curvature > 0.0 else np.inf
    of_readings = tuple((_SCALES[joint], np.array([factor - 1.0])) for joint in joints)
    return EncoderScale(joints, factor, factor * std, replace(found, found=(*of_readings, *found.found)))


def _turned(pieces: Pieces, joints: Joints, logarithm: float, effects: tuple[Effect, ...]) -> ForceBalance | None:
    """Return the balance with the angles put right by a factor; None where it cannot be computed."""
    inner, outer = (float(np.exp(-logarithm)) if joint in joints else 1.0 for joint in JOINTS)
    try:
        return balance_of_forces(pieces.with_joints_turned(inner, outer), effects)
    except (IdentificationError, np.linalg.LinAlgError):
        return None


def _misfit(found: ForceBalance | None) -> float:
    """Return what is left, infinite where it cannot be computed."""
    return found.misfit if found and np.isfinite(found.misfit) else np.inf
