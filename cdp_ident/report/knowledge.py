# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a rig before its next trial, read again from the folder of a report, and what became of it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.configuration.fitted_model import fitted_model, fitted_parameters
from cdp_ident.design.discrimination import RecordedMotion
from cdp_ident.design.knowledge import Knowledge, Sampling
from cdp_ident.errors import ReportError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import Noise
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.parameters import GROUPS, INERTIA, INVERSE_INERTIA
from cdp_ident.model.weights import Weight
from cdp_ident.report.curves import Curves
from cdp_ident.report.next_trial import NOISES
from cdp_ident.report.schema import Also, Section
from cdp_ident.tracing.found_effects import FoundEffect
from cdp_ident.tracing.select_effects import ExpectedEffect
from cdp_ident.trial.trial import Trial

_SPANS = ("duration", "interval", "spacing", "step")
"""Times that are assumed of a next trial, as `Sampling` names them."""
_NO_ESTIMATE = {"as_fitted": {"value": np.inf, "std": np.inf}}
"""Of a parameter that a report does not have."""
_MOST_SAMPLES = 1_000_000
"""Of a trial that a report assumes."""


def knowledge_of(report: Section) -> Knowledge | None:
    """Return what a report says is known; None where it says nothing of a next trial, as where the fit failed.

    Raises:
        CdpIdentError: its model, or what it assumes of a trial, cannot be.
    """
    if report["next_trial"] is None:
        return None
    assumed = report["next_trial"]["assumed"]
    _refuse_endless(assumed)
    fitted = fitted_model({p.name: p.value for p in fitted_parameters(report)}, "the report")
    correlation = report["after"]["correlation"]
    names, physical = correlation["names"], report["after"]["physical"]
    model, values = fitted.motion, fitted.values
    constants = [symbol for symbol in ("L", "g") if symbol in names]
    errors = report["after"]["weight_errors"]
    trials = {trial["name"]: index for index, trial in enumerate(report["trials"])}
    effects = tuple(
        active if active.trial is None else replace(active, trial=trials.get(fitted.trials[active.trial], len(trials)))
        for active in model.effects
    )
    model = replace(
        model,
        effects=effects,
        length_std=np.inf if "L" in names else 0.0,
        gravity_std=np.inf if "g" in names else 0.0,
        inertia_free=INVERSE_INERTIA.symbol in names,
        weight_errors=tuple((error["of"], error["rod"], error["given"]) for error in errors),
    )
    base = [physical[symbol]["value"] for symbol in constants]
    base += [1.0 / model.mechanism.inertia] * model.inertia_free + [error["value"] for error in errors]
    values = np.insert(values, len(GROUPS), base)
    noise = Noise(**{of: _of_joints(assumed[name]) for name, of in NOISES.items()})
    sampling = Sampling(steps=_of_joints(assumed["step_rad"]), **{span: assumed[f"{span}_s"] for span in _SPANS})
    covariance = _covariance(model, _standard_deviations(report, model), correlation)
    zeros = tuple(joint for joint in JOINTS if any(name.startswith(f"zero.{joint}.") for name in names))
    return Knowledge(model, values, covariance, noise, sampling).with_weights(()).with_zeros_of_its_own(zeros)


def _of_joints(given: Any) -> Any:
    """Return what is given of each joint as an array (2,); what is given of both together as it is."""
    return np.array([given[joint] for joint in JOINTS]) if isinstance(given, dict) else given


def _refuse_endless(assumed: Section) -> None:
    """Raise `ReportError` where no trial as a report assumes it could be simulated: a report may come from anyone."""
    shortest = min(assumed[f"{span}_s"] for span in _SPANS)
    endless = shortest <= 0.0 or not assumed["duration_s"] < _MOST_SAMPLES * shortest
    sizes = [_of_joints(assumed[name]) for name in ("new_noise_rad", "unknown_torque_over_A22")]
    late = assumed["time_noise_s"] < 0.0
    if endless or late or np.min(sizes) <= 0.0 or np.max(np.abs(_of_joints(assumed["noise_kept"]))) >= 1.0:
        raise ReportError("what the report assumes of a next trial is no trial; was it changed? identify again")


def _standard_deviations(report: Section, model: MotionModel) -> Array:
    """Return the standard deviations (unknowns,) of a model's values."""
    after, inertia = report["after"], report["after"]["physical"][INERTIA.symbol]["value"]
    std = [after["groups"][group.symbol]["std"] for group in GROUPS]
    std += [after["physical"][symbol]["std"] for symbol in ("L", "g") if symbol in model.base_names]
    if model.inertia_free:
        std.append(after["physical"][INERTIA.symbol]["std"] / inertia**2)
    std += [error["std"] for error in after["weight_errors"]]
    for effect, active in zip(report["effects"], model.effects, strict=True):
        if effect["curve"]:
            std += [deviation / inertia for deviation in effect["curve"]["coefficients_std"]]
        else:
            std += [effect["parameters"][p.name]["as_fitted"]["std"] for p in active.fitted]
    return np.array(std)


def _covariance(model: MotionModel, std: Array, correlation: Section) -> Array:
    """Return the covariance (unknowns, unknowns); coefficients of curves count as uncorrelated."""
    names = correlation["names"]
    shared = [name for name in model.names if name in names]
    rows, places = [names.index(name) for name in shared], [model.names.index(name) for name in shared]
    matrix = np.array(correlation["matrix"])[np.ix_(rows, rows)]
    together = np.eye(len(std))
    together[np.ix_(places, places)] = np.where(np.isfinite(matrix), matrix, 0.0)
    np.fill_diagonal(together, 1.0)
    finite = np.where(np.isfinite(std), std, 0.0)
    result = together * np.outer(finite, finite)
    result[np.diag_indices(len(std))] = std**2
    return np.asarray(result)


def recorded_motion(report: Section, curves: Curves, knowledge: Knowledge) -> RecordedMotion:
    """Return the motion of the trials of a report, of which the fitted model says something."""
    trials = list[Trial]()
    for index, curve in enumerate(curves.trials):
        weights = tuple(Weight(**weight) for weight in report["trials"][index]["weights"])
        cart = curve.cart if np.ptp(curve.cart) else None
        trials.append(Trial(str(index), curve.time, curve.measured, cart, weights=weights))
    return RecordedMotion.of(knowledge, trials)


def expected_effects(report: Section) -> tuple[ExpectedEffect, ...]:
    """Return the effects of a report that may be expected again.

    Effects of one trial are left out, and so are nonparametric torques, whose shapes belong to their trials.
    """
    sections = {
        (section["name"], section["joint"], section["variant"]): section
        for section in report["effects"]
        if section["trial"] is None
    }
    found = []
    for effect in known_effects():
        section = sections.get((effect.name, effect.joint, effect.variant))
        if section is None or effect.curve is not None:
            continue
        fitted = [section["parameters"].get(p.name, _NO_ESTIMATE)["as_fitted"] for p in ActiveEffect(effect).fitted]
        values, std = (np.array([estimate[of] for estimate in fitted]) for of in ("value", "std"))
        if np.all(np.isfinite(values)):
            found.append(ExpectedEffect(effect, values, std))
    return tuple(found)


def compared(expected: Sequence[ExpectedEffect], found: Sequence[FoundEffect]) -> list[Also]:
    """Return what became of each effect that was expected, and which effects are new."""
    new = {effect.active.effect.key: effect for effect in found if not effect.active.is_difference}
    sections = []
    for before in expected:
        now = new.pop(before.effect.key, None)
        became = {"state": "confirmed" if now else "withdrawn", "parameters": _changes(before, now) if now else {}}
        sections.append(Also(before.effect, became))
    return [*sections, *(Also(now.active.effect, {"state": "new", "parameters": {}}) for now in new.values())]


def _changes(before: ExpectedEffect, now: FoundEffect) -> Section:
    shown, changes = {parameter.description.name: parameter for parameter in now.parameters}, {}
    for parameter, value, std in zip(ActiveEffect(before.effect).fitted, before.values, before.std, strict=True):
        new = shown[parameter.name]
        change, spread = abs(new.shown - value), np.hypot(std, new.shown_std)
        changes[parameter.name] = value, new.shown, change / spread if spread > 0.0 else 0.0
    return changes
