"""From an identification to the effects that explain its residual, in physical units and in words."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.identification.continuity import continuity
from cdp_ident.identification.identify import Identification
from cdp_ident.identification.judgement import Errors, judge
from cdp_ident.identification.motion_model import ActiveEffect, MotionModel
from cdp_ident.identification.physical import PhysicalValues, nearest_physical_values
from cdp_ident.identification.refinement import Fit
from cdp_ident.identification.repeatability import repeatability
from cdp_ident.identification.uncertainty import covariance
from cdp_ident.model.effects.effect import EffectParameter, SensorEffect
from cdp_ident.model.parameters import GROUPS, inertia_about_cart
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.ladder import Ladder, climb
from cdp_ident.tracing.unexplained import Unexplained, unexplained

Array = npt.NDArray[np.float64]

_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"))


@dataclass(frozen=True)
class FoundParameter:
    """A parameter of an effect, in its physical unit."""

    description: EffectParameter
    value: float
    std: float
    """0 for one that is a part of the effect's definition."""


@dataclass(frozen=True)
class FoundEffect:
    """An effect that was added to the model."""

    active: ActiveEffect
    parameters: tuple[FoundParameter, ...]
    holdout_without: float
    """Error over the windows kept out of the fit, of the model without this effect [rad]."""
    holdout_with: float
    """The same of the model with all effects [rad]."""
    delta_bic: float
    """Bayes's information criterion of the model with all effects less that of the one without this effect."""
    also_possible: tuple[str, ...]
    """Effects that the data cannot tell from this one."""


@dataclass(frozen=True)
class Trace:
    """What an identification's residual was traced to."""

    ladder: Ladder
    effects: tuple[FoundEffect, ...]
    completed: Identification
    """The identification, with the model that has the effects in the paper's model's place."""
    errors: tuple[Errors, Errors]
    """Errors of the model with the effects, over the fitted and over the held-out windows."""
    unexplained: Unexplained
    verdict: str
    """The result in one sentence for people."""

    @property
    def after(self) -> Attempt:
        """The model with the effects."""
        return self.ladder.after

    @property
    def covariance(self) -> Array:
        """(unknowns, unknowns) covariance of the values of the model with the effects."""
        return self.completed.covariance

    @property
    def physical(self) -> PhysicalValues:
        """Physical values of the model with the effects."""
        return self.completed.physical


def trace(
    found: Identification, told: Callable[[str], None] = lambda line: None, stop: Callable[[], bool] = lambda: False
) -> Trace:
    """Trace the residual of an identification to effects that the paper's model lacks.

    Args:
        found: the paper's model, identified.
        told: called with a line for people after each step.
        stop: asked now and then; true ends the tracing with the effects found so far.
    """
    ladder = climb(found.fit, found.data.holdout, float(np.sqrt(np.mean(found.data.noise**2))), told, stop)
    completed = _completed(found, ladder.after.fit)
    after, physical = ladder.after, completed.physical
    values, spread = after.fit.values, completed.covariance
    length, _ = after.model.constants(values)
    inertia = float(inertia_about_cart(physical.values, length))
    effects = tuple(
        _found(ladder, index, spread, inertia, physical.inertia_relative_std)
        for index in range(len(after.model.effects))
    )
    remains = unexplained(after, found.data.noise, found.data.names, inertia)
    return Trace(
        ladder=ladder,
        effects=effects,
        completed=completed,
        errors=(
            judge(after.model, values, found.data.fit, found.data.trials),
            judge(after.model, values, found.data.holdout, found.data.trials),
        ),
        unexplained=remains,
        verdict=_verdict(ladder, effects, remains, found.data.noise),
    )


def _completed(found: Identification, fit: Fit) -> Identification:
    """Return an identification with another fit, and all that follows from it."""
    if fit is found.fit:
        return found
    assert isinstance(fit.model, MotionModel)
    spread, count = covariance(fit), len(GROUPS)
    length, _ = fit.model.constants(fit.values)
    return replace(
        found,
        estimate=replace(found.estimate, fit=fit),
        covariance=spread,
        physical=nearest_physical_values(fit.values[:count], spread[:count, :count], found.options.prior, length),
        continuity=continuity(fit),
        repeatability=repeatability(fit, found.data.names),
    )


def _found(ladder: Ladder, index: int, spread: Array, inertia: float, inertia_std: float) -> FoundEffect:
    after = ladder.after
    active, place = after.model.effects[index], after.model.places(index)
    fitted = iter(zip(after.fit.values[place], np.sqrt(np.diag(spread)[place]), strict=True))
    parameters = []
    for parameter in active.effect.parameters:
        value, std = (parameter.typical, 0.0) if parameter.fixed else next(fitted)
        scale = parameter.scale(inertia)
        # A torque is seen over A22 only; in N m it is as uncertain as the masses besides.
        scale_std = abs(parameter.inertia_power * value) * inertia_std
        parameters.append(FoundParameter(parameter, float(value) * scale, float(np.hypot(std, scale_std)) * scale))
    return FoundEffect(
        active=active,
        parameters=tuple(parameters),
        holdout_without=ladder.holdout_without[index],
        holdout_with=after.holdout.rmse(),
        delta_bic=ladder.evidence[index].bic,
        also_possible=ladder.also_possible[index],
    )


def _verdict(ladder: Ladder, effects: tuple[FoundEffect, ...], remains: Unexplained, noise: Array) -> str:
    before, after = ladder.before.holdout.rmse(), ladder.after.holdout.rmse()
    floor = float(np.sqrt(np.mean(noise**2)))
    rest = "the rest is encoder noise" if not remains.significant else f"something remains: {remains.description}"
    if not effects:
        if not remains.significant:
            return (
                f"The paper's model explains the motion: what it leaves, {_milliradians(after)} mrad, is encoder noise."
            )
        return f"The paper's model leaves more than noise, and no known effect explains it; {rest}."
    share = 1.0 - max(after**2 - floor**2, 0.0) / max(before**2 - floor**2, 1e-300)
    names = ", and ".join(_words(effect) for effect in sorted(effects, key=lambda e: -e.holdout_without))
    verb = "explains" if len(effects) == 1 else "explain"
    return (
        f"{names[0].upper()}{names[1:]}, {verb} {100 * share:.0f} % of what the paper's model could not: "
        f"{_milliradians(before)} -> {_milliradians(after)} mrad on held-out motion; {rest}."
    )


def _words(effect: FoundEffect) -> str:
    description, joint = effect.active.effect.description, effect.active.effect.joint
    place = {
        True: {"inner": " (the inner encoder)", "outer": " (the outer encoder)"},
        False: {"inner": " in the inner joint", "outer": " in the outer joint"},
    }[isinstance(effect.active.effect, SensorEffect)].get(joint, "")
    if effect.active.effect.name in ("air_drag", "impulse"):
        place = f" ({joint})"
    strength = next((p for p in effect.parameters if not p.description.shape and p.value != 0), effect.parameters[0])
    alternatives = f" (or {' or '.join(effect.also_possible)}, which the data cannot tell from it)"
    return f"{description}{place}, {_with_unit(strength)}{alternatives if effect.also_possible else ''}"


def _with_unit(parameter: FoundParameter) -> str:
    unit = "" if parameter.description.unit == "1" else parameter.description.unit
    size = max(abs(parameter.value), parameter.std)
    factor, prefix = next(((f, p) for f, p in _PREFIXES if size >= f), _PREFIXES[-1]) if unit else (1.0, "")
    return f"{parameter.value / factor:.3g} ± {parameter.std / factor:.1g} {prefix}{unit}".rstrip()


def _milliradians(error: float) -> str:
    return f"{1e3 * error:.3g}"
