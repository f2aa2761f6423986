# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A linear model for people and for other programs."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from cdp_ident.arrays import Array
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.linear import INPUTS, OUTPUTS, STATES, LinearModel, Mode

SCHEMA = "cdp_ident/linear_model/1"


def linear_model_content(model: LinearModel, at: str, left_out: Sequence[Effect]) -> dict[str, Any]:
    """Return what the file of a linear model says.

    `at` is the name of its equilibrium; `left_out` are effects of the fitted model that have no linear part.
    """
    return {
        "schema": SCHEMA,
        "at": at,
        "theta1_rad": float(model.theta[0]),
        "theta2_rad": float(model.theta[1]),
        "states": STATES,
        "inputs": INPUTS,
        "outputs": OUTPUTS,
        **{name: getattr(model, name).tolist() for name in "ABCD"},
        "modes": [
            {
                "real_per_s": mode.eigenvalue.real,
                "imaginary_per_s": mode.eigenvalue.imag,
                "frequency_rad_per_s": mode.frequency,
                "damping": mode.damping,
            }
            for mode in model.modes
        ],
        "controllable": model.controllable,
        "controllability": model.controllability,
        "left_out": [effect.key for effect in left_out],
    }


def linear_model_lines(model: LinearModel, at: str, left_out: Sequence[Effect]) -> Iterator[str]:
    """Yield a linear model as text for a terminal; the arguments are those of `linear_model_content`."""
    theta1, theta2 = model.theta
    yield f"{at}: deviations from theta1 = {theta1:.6g}, theta2 = {theta2:.6g} rad"
    for word, names in (("state", STATES), ("input", INPUTS), ("output", OUTPUTS)):
        yield f"  {word:<7}{', '.join(f'{name} [{unit}]' for name, unit in names.items())}"
    yield ""
    yield from _matrix("A", model.A)
    yield from _matrix("B", model.B)
    yield "C picks x, theta1, theta2 of the state; D = 0"
    yield ""
    yield f"{'mode':<24}{'eigenvalue [1/s]':<24}{'frequency [rad/s]':<20}{'damping'}"
    for mode in model.modes:
        eigenvalue = f"{mode.eigenvalue.real:.5g}"
        if mode.eigenvalue.imag:
            eigenvalue += f" ± {mode.eigenvalue.imag:.5g}i"
        yield f"{_behaviour(mode):<24}{eigenvalue:<24}{mode.frequency:<20.5g}{mode.damping:.4g}"
    yield ""
    able = "controls every mode" if model.controllable else "cannot control every mode"
    yield f"The cart {able}; the nearest model of which it does not is {model.controllability:.3g} away."
    for effect in left_out:
        joint = "" if effect.joint == "base" else f" ({effect.joint} joint)"
        yield f"Left out, as it has no linear part: {effect.description}{joint}"


def _matrix(name: str, matrix: Array) -> Iterator[str]:
    for row, values in enumerate(matrix):
        head = f"{name} = " if row == 0 else ""
        yield f"{head:<4}" + "".join(f"{value + 0.0:>12.6g}" for value in values)
    yield ""


def _behaviour(mode: Mode) -> str:
    rate = mode.eigenvalue.real
    if rate == 0.0:
        return "stays" if not mode.eigenvalue.imag else "swings on"
    time = math.log(2.0) / abs(rate)
    return f"{'doubles' if rate > 0.0 else 'halves'} in {time:.3g} s"
