"""What the balance of forces is made of: the terms of each unknown along measured motions, and their limits."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cdp_ident.fit import weak_form
from cdp_ident.fit.noise import encoder_steps
from cdp_ident.fit.smoothing import SmoothMotion, smooth
from cdp_ident.fit.weak_form import Kinematics, Rows, Term, Windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.effects.effect import EffectParameter, Form, TorqueEffect
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, coefficients_of, time_unit
from cdp_ident.model.torques import Torques
from cdp_ident.model.trajectory import accelerations_at
from cdp_ident.model.weights import Weight, added_by
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

MOMENT = "m2_l2_over_A22"
"""Name of the unknown by which L is sought: it is A23 over this."""
_LOOKED_FOR = tuple(effect for effect in CATALOGUE if isinstance(effect, TorqueEffect) and effect.in_balance)
DRY = tuple(effect for effect in _LOOKED_FOR if effect.dry)
"""The dry friction that is looked for, which may be in several joints together."""
NOT_DRY = tuple(effect for effect in _LOOKED_FOR if not effect.dry)
"""What else is looked for."""

_GRID = 1.0 / 40.0
"""Spacing of the grid, in time units: a fast swing of a double pendulum has some ten points a radian of phase."""
_REST = 1.0
"""A joint that hardly moves for so many time units is at rest."""
_COPIES, _LONG = 4, 100.0
"""Copies with added noise: so many of a motion, but one of a motion longer than so many time units, which is enough."""
_SEED = 1
"""Seed of the copies' noise: the same trials give the same result."""
_NUDGE = 1e-3
"""An effect's torque is computed at this share of its typical strength, where it is (nearly) linear in it."""
_UNIT_INERTIA = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
"""Coefficients with which accelerations are equal to the torques of effects."""


@dataclass(frozen=True)
class Unknowns:
    """What is sought beside the five base parameters."""

    effects: tuple[TorqueEffect, ...] = ()
    """Torques of the catalogue."""
    length_free: bool = False
    inertia_free: bool = False
    """Whether 1 / A22 is sought, which weights show."""

    @cached_property
    def of_effects(self) -> tuple[tuple[TorqueEffect, int, EffectParameter], ...]:
        """Each effect's parameters in which its torque is linear, with their places among its parameters."""
        return tuple(
            (effect, place, parameter)
            for effect in self.effects
            for place, parameter in enumerate(effect.parameters)
            if not parameter.shape and not parameter.fixed
        )

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the base parameters and of what else is sought, all relative to A22."""
        return (
            *(group.symbol for group in GROUPS),
            *((MOMENT,) if self.length_free else ()),
            *((INVERSE_INERTIA.symbol,) if self.inertia_free else ()),
            *(f"{effect.key}.{parameter.name}" for effect, _, parameter in self.of_effects),
        )

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest value of each: inertias, moments and frictions are not negative."""
        parameters = [parameter for _, _, parameter in self.of_effects]
        plain = len(self.names) - len(parameters)
        lower = [0.0] * plain + [parameter.lower for parameter in parameters]
        upper = [np.inf] * plain + [parameter.upper for parameter in parameters]
        return np.array(lower), np.array(upper)


@dataclass(frozen=True)
class Piece:
    """A trial's smooth motion, with copies that have noise added."""

    motion: SmoothMotion
    kinematics: Kinematics
    resting: tuple[weak_form.Mask, weak_form.Mask]
    """(m,) where the inner and the outer joint rest."""
    weights: tuple[Weight, ...] = ()
    """The known weights on the rods."""

    @classmethod
    def of(cls, trial: Trial, time_unit: float) -> "Piece":
        """Smooth a trial on a grid of the rig's time unit [s]."""
        samples = trial.theta
        if trial.cart is not None and np.ptp(trial.cart) > 0:
            samples = np.column_stack([samples, trial.cart])
        copies = 1 if trial.duration > _LONG * time_unit else _COPIES
        motion = smooth(trial.time, samples, _GRID * time_unit, copies, np.random.default_rng(_SEED))
        kinematics = Kinematics.of(motion)
        points = round(_REST / _GRID)
        steps = encoder_steps(trial)
        inner, outer = (weak_form.at_rest(kinematics, joint, points, float(steps[joint])) for joint in range(2))
        return cls(motion, kinematics, (inner, outer), trial.weights)

    def without_copies(self) -> "Piece":
        """Return the motion as measured alone: what noise does is not allowed for then."""
        return self._moving(replace(self.motion, values=self.motion.values[:1], rates=self.motion.rates[:1]))

    def with_joints_turned(self, inner: float, outer: float) -> "Piece":
        """Return the motion as if the joints had turned so many times as far from where the rods hang."""
        motion = self.motion
        change = np.eye(motion.values.shape[-1])
        change[:2, :2] = [[inner, 0.0], [inner - outer, outer]]
        rest = np.zeros(len(change))
        rest[:2] = math.pi
        values, rates = rest + (motion.values - rest) @ change.T, motion.rates @ change.T
        return self._moving(replace(motion, values=values, rates=rates, noise=change @ motion.noise @ change.T))

    def _moving(self, motion: SmoothMotion) -> "Piece":
        return replace(self, motion=motion, kinematics=Kinematics.of(motion))


@dataclass(frozen=True)
class Mechanism:
    """The balance of forces of a pendulum of which some lengths and gravity are known."""

    length: float
    """L [m]."""
    gravity: float
    """g [m/s^2]."""
    outer_length: float
    """Of the outer rod [m]."""

    @property
    def time_unit(self) -> float:
        """The rig's own unit of time [s]."""
        return time_unit(self.length, self.gravity)

    def rows(
        self,
        pieces: Sequence[Piece],
        unknowns: Unknowns,
        half_width: float,
        groups: Array,
        inverse_inertia: float = 0.0,
    ) -> Rows:
        """Return the balance in windows of a half width [s] over all pieces.

        Effects whose torque depends on the base parameters, as that of a tilt does, take the ones given (5,), and 1 /
        A22 [1/(kg m^2)] where there are weights.
        """
        parts = []
        for piece in pieces:
            windows = Windows.of(half_width, piece.motion.spacing)
            if len(piece.motion.time) < len(windows.value):
                continue
            k = piece.kinematics
            numerators = groups + inverse_inertia * added_by(piece.weights, self.length)[1:]
            terms = list(self._terms(piece, unknowns, numerators))
            parts.append(
                weak_form.rows(windows, piece.motion.known, terms, weak_form.inertia_of_inner_rod(k), piece.resting)
            )
        return weak_form.joined(parts, len(unknowns.names))

    def gravity_torque(self, unknowns: Unknowns, values: Array, pieces: Sequence[Piece]) -> Array:
        """Return the root mean square of gravity's torque (2,) in the inner and the outer joint, over A22 [rad/s^2]."""
        a1 = values[unknowns.names.index("a1_over_A22")]
        outer_moment = values[unknowns.names.index(MOMENT)] if unknowns.length_free else values[0] / self.length
        theta1, theta2 = (np.concatenate([getattr(p.kinematics, n)[0] for p in pieces]) for n in ("theta1", "theta2"))
        outer = outer_moment * self.gravity * np.sin(theta2)
        inner = outer + a1 * self.gravity * np.sin(theta1)
        return np.sqrt([np.mean(inner**2), np.mean(outer**2)])

    def length_of(self, unknowns: Unknowns, values: Array) -> float:
        """Return L [m], as known or as found; not a number where the outer rod's moment, which shows it, is zero."""
        if not unknowns.length_free:
            return self.length
        moment = float(values[unknowns.names.index(MOMENT)])
        return float(values[0]) / moment if moment else float("nan")

    def _terms(self, piece: Piece, unknowns: Unknowns, groups: Array) -> Iterator[Term]:
        k = piece.kinematics
        outer_moment = weak_form.moment_of_outer_rod(k, self.gravity)
        coupling = weak_form.coupling(k).plus(outer_moment, 1.0 / self.length)
        if unknowns.length_free:
            yield weak_form.coupling(k)
        else:
            yield coupling
        yield weak_form.inertia_of_outer_rod(k)
        yield weak_form.moment_of_inner_rod(k, self.gravity)
        yield weak_form.joint_torques(k.joint_speeds[0], 0.0)
        yield weak_form.joint_torques(0.0, k.joint_speeds[1])
        if unknowns.length_free:
            yield outer_moment
        if unknowns.inertia_free:
            terms = (
                weak_form.inertia_of_inner_rod(k),
                coupling,
                weak_form.inertia_of_outer_rod(k),
                weak_form.moment_of_inner_rod(k, self.gravity),
            )
            yield weak_form.weighted_sum(terms, added_by(piece.weights, self.length)[: len(terms)])
        for effect, place, parameter in unknowns.of_effects:
            yield self._torque(k, effect, place, parameter, groups)

    def _torque(
        self, k: Kinematics, effect: TorqueEffect, place: int, parameter: EffectParameter, groups: Array
    ) -> Term:
        """Return an effect's torque over one of its parameters."""
        if effect.form is Form.COUPLING:
            return weak_form.constant_coupling(k)
        values = [other.typical if other.shape or other.fixed else 0.0 for other in effect.parameters]
        values[place] = _NUDGE * (parameter.typical or 1.0)
        coefficients = coefficients_of(groups, self.length, self.gravity)
        constants = effect_constants(coefficients, self.length, self.outer_length)
        states = np.stack([k.theta1, k.theta2, k.w1, k.w2], axis=-1).reshape(-1, 4)
        torques = accelerations_at(
            _UNIT_INERTIA, states, np.zeros(len(states)), Torques.of([(effect, values)], constants)
        )
        on_theta1, on_theta2 = (torques / values[place]).T.reshape(2, *k.theta1.shape)
        if effect.dry:
            # Its size is the law's; its direction allows for the speed's noise.
            if effect.joint == "inner":
                return weak_form.joint_torques(np.abs(on_theta1) * weak_form.slip_direction(k, 0), 0.0)
            return weak_form.joint_torques(0.0, np.abs(on_theta2) * weak_form.slip_direction(k, 1))
        return weak_form.rod_torques(on_theta1, on_theta2)
