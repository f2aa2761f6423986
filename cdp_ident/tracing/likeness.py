# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes that the catalogue has no effect for, and to which a nonparametric torque is similar."""

import numpy as np

from cdp_ident.arrays import Array

_ALIKE, _BY_MORE = 0.8, 0.03
"""A cause is mentioned if its shape explains at least so much of a curve's mean square, and by so much more than one
that is the same everywhere."""
_PLACES = 41
"""Number of places where a rub is tried, over the range that the motion covers."""
_WIDTHS = np.geomspace(0.04, 0.6, 12)
"""How far to each side it may reach [rad]."""


def likeness(over: str, dry: bool, at: Array, torque: Array) -> str:
    """Return in words what could cause such a torque; empty where nothing is similar that the catalogue lacks.

    Args:
        over: what the torque depends on, the joint's angle or its speed.
        dry: whether it is the size of dry friction.
        at: (n,) angles from hanging [rad] or speeds [rad/s], evenly over the range that the motion covers.
        torque: (n,) there.
    """
    if over != "angle":
        return ""
    if not dry:
        return "an unbalance" if _explained(torque, np.sin(at), np.cos(at)) > _ALIKE else ""
    rubs = [
        (_explained(torque, (np.abs(at - place) <= half).astype(float)), float(place))
        for place in np.linspace(at[0], at[-1], _PLACES)
        for half in _WIDTHS
    ]
    share, place = max(rubs)
    least = max(_ALIKE, _explained(torque, np.ones_like(at)) + _BY_MORE)
    return f"a part of the turn that rubs at {place:.2g} rad" if share > least else ""


def _explained(torque: Array, *columns: Array) -> float:
    """Return the share of a torque's mean square that columns (n,) explain."""
    shapes = np.column_stack(columns)
    left = torque - shapes @ np.linalg.lstsq(shapes, torque, rcond=1e-10)[0]
    return 1.0 - float(left @ left) / max(float(torque @ torque), 1e-300)
