# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Damaged and hostile texts (rigs, own effects, models, reports, tables ...): read, or refused in one short line."""

import random
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from cdp_ident.bag.csv_file import read_table
from cdp_ident.configuration.fitted_model import read_fitted_model
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import Settings
from cdp_ident.errors import CdpIdentError
from cdp_ident.model.effects.own import effects_of, read_own_effects
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.report.report_file import read_report
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.rig.joints import load_zero
from fuzz.campaign import FindingError
from fuzz.mutation import mutated_text

_CONFIG = Path(__file__).parents[1] / "config"
_LONGEST = 2000
_FITTED = {
    **NOMINAL,
    "effects.coulomb_friction.outer.torque": 0.002,
    "effects.quadratic_friction.inner.coefficient": 1e-4,
}
_OWN = """
cable:
  joint: [inner, outer]
  where: {bend: angle - twist}
  torque: -stiffness*tanh(bend) - damping*speed*abs(sin(bend))
  states: {twist: {rate: speed - twist/0.1, limit: 2.0}}
  parameters:
    stiffness: {unit: N m, limits: [0, 10], typical: 0.1}
    damping: {unit: N m s/rad, limits: [0, 1], typical: 0.01, prior_width: 0.1}
"""
_ZERO = {"cart_counts": 0.0, "inner_counts": 12.5, "outer_counts": -3.0, "sequence": 7, "taken_at_ns": 10**18}
_TABLE = "t [s];theta1 [deg];theta2 [deg]\n" + "".join(f"{k / 100},5;{k}.25;-{k}\n" for k in range(60))


def case(generator: random.Random) -> str:
    """Damage one of the texts that users hand over, and read it."""
    kind, content, read = generator.choice(good_texts())
    with TemporaryDirectory() as name:
        path = Path(name) / "some"
        path.write_bytes(mutated_text(content, generator))
        try:
            read(path)
        except CdpIdentError as error:
            if len(str(error)) > _LONGEST:
                raise FindingError(f"{kind}: an error of {len(str(error))} letters") from error
            return f"{kind}: refused"
    return f"{kind}: read"


@cache
def good_texts() -> tuple[tuple[str, bytes, Callable[[Path], Any]], ...]:
    """Return kinds of texts, a good one of each, and what reads it."""
    return (
        (
            "configuration",
            (_CONFIG / "identify.yaml").read_bytes(),
            lambda path: Settings.of(read_parameter_file(path, "identify").taken()),
        ),
        ("rig", (_CONFIG / "emulated_rig.yaml").read_bytes(), load_rig),
        ("own effects", _OWN.encode(), lambda path: effects_of(read_own_effects(path), 0.02, str(path))),
        ("zero", yaml.safe_dump(_ZERO).encode(), load_zero),
        (
            "fitted model",
            yaml.safe_dump({"/**": {"ros__parameters": _FITTED}}).encode(),
            lambda path: read_fitted_model(path, "linearize"),
        ),
        ("report", _report(), read_report),
        ("table", _TABLE.encode(), read_table),
    )


@cache
def _report() -> bytes:
    return (Path(__file__).parent / "report.json").read_bytes()
