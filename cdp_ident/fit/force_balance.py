"""The base parameters and dry friction from measured angles alone, without initial values, a box or a simulation.

The balance of forces (`weak_form`) is linear in the base parameters once L and g are known, for A23 = m2 l2 L. Its
regressors come from smoothed angles (`smoothing`), whose noise is allowed for (`robust_regression`). All times are
multiples of the rig's sqrt(L / g).
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.balance_unknowns import DRY, Mechanism, Piece, Unknowns
from cdp_ident.fit.robust_regression import Regression, regress
from cdp_ident.fit.smoothing import FEWEST
from cdp_ident.fit.weak_form import STEPS_BETWEEN, Rows
from cdp_ident.model.effects.effect import JOINTS, Effect, Form, SensorEffect, TorqueEffect
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA
from cdp_ident.model.weights import added_by
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_HALF_WIDTHS = (0.5, 1.0, 2.0)
"""Half widths of the test functions that are tried, in time units; the period of a small swing is some 2 pi units."""
_LITTLE_NOISE = 0.01
"""Largest share of an unknown's information that may be noise; the narrowest windows that keep to it are taken."""
_NO_TORQUE = 1e-150
"""Stands for a torque of gravity that is found to be zero, over A22 [rad/s^2]: shares of it are huge, and finite."""
_FEWEST_ROWS = 1
"""Independent windows for each unknown that are needed at least."""
CLEARLY_BETTER = 20.0
"""A balance with one more unknown is clearly the better one where it lowers the information criterion by so much."""
_MARGIN = 1.02
"""Least ratio of A33 A22 to A23^2: the rods' masses are not points."""
_ROUNDS = 5
_LARGEST = 1e6
"""No outer rod has so many times the inertia of all that turns about the cart's joint."""
_A23, _A33 = 0, 1


@dataclass(frozen=True)
class ForceBalance:
    """What the balance of forces says about a pendulum."""

    unknowns: Unknowns
    values: Array
    """(n,) values of `names`, over A22."""
    covariance: Array
    """(n, n) of the values; zero for one at a limit, infinite for one of which the trials say nothing."""
    criterion: float
    """Bayesian information criterion, the least of the choices of effects that were compared."""
    unexplained: Array
    """(2,) what is left of the inner and of the outer joint's balance, as a share of gravity's torque in it (robust
    standard deviation over root mean square)."""
    noise_share: Array
    """(2,) what the angles' noise alone leaves, as the same share."""
    used: Array
    """(2,) share of the windows in which either balance counts: none where its joint rests, or near ends and gaps."""
    windows: int
    """Windows altogether; neighbours overlap."""
    half_width: float
    """Of the windows [s]."""
    noise: Array
    """(2,) standard deviation of what theta1 and theta2 scatter by about a smooth motion [rad]."""
    length: float
    """L [m], as known or as found."""
    of_readings: tuple[tuple[SensorEffect, Array], ...] = ()
    """Errors of encoders that were taken out of the angles before, and their values (k,)."""

    @property
    def names(self) -> tuple[str, ...]:
        """Base parameters, on request m2 l2 and 1 / A22, then parameters of effects."""
        return self.unknowns.names

    @property
    def effects(self) -> tuple[TorqueEffect, ...]:
        """The effects that were found."""
        return self.unknowns.effects

    @property
    def found(self) -> tuple[tuple[Effect, Array], ...]:
        """The effects that were found, errors of encoders first, and the values (k,) of what each is linear in."""
        return (*self.of_readings, *((effect, self.strengths(effect)) for effect in self.effects))

    @property
    def beyond_noise(self) -> Array:
        """(2,) the unexplained shares without those of noise."""
        return np.sqrt(np.maximum(self.unexplained**2 - self.noise_share**2, 0.0))

    @property
    def misfit(self) -> float:
        """Minus twice the logarithm of the likelihood, but for a constant, of what is left as a share of gravity's."""
        independent = self.used * self.windows / STEPS_BETWEEN
        return float(2.0 * independent @ np.log(np.maximum(self.unexplained, np.finfo(float).tiny)))

    def strengths(self, effect: TorqueEffect) -> Array:
        """Return the values (k,) of what an effect's torque is linear in; empty where it was not found."""
        first = len(self.names) - len(self.unknowns.of_effects)
        return self.values[first:][[found == effect for found, _, _ in self.unknowns.of_effects]]

    @property
    def groups(self) -> Array:
        """(5,) the base parameters, in the order of `GROUPS`."""
        return self.values[: len(GROUPS)]

    @property
    def inertia(self) -> float | None:
        """A22 [kg m^2]; None where no weights show it."""
        inverse = self.value(INVERSE_INERTIA.symbol) if self.unknowns.inertia_free else 0.0
        return 1.0 / inverse if inverse > 0.0 else None

    def groups_of(self, trial: Trial) -> Array:
        """Return the base parameters (5,) as a trial shows them, whose rods may have weights."""
        added = added_by(trial.weights, self.length) / (self.inertia or np.inf)
        return (self.groups + added[1:]) / (1.0 + added[0])

    @property
    def std(self) -> Array:
        """(n,) standard deviations of the values."""
        return np.sqrt(np.diag(self.covariance))

    def value(self, name: str) -> float:
        """Return the value of one unknown."""
        return float(self.values[self.names.index(name)])


def balance_of_forces(
    trials: Sequence[Trial],
    length: float,
    gravity: float,
    *,
    effects: Sequence[TorqueEffect] = (),
    optional: Sequence[TorqueEffect] = DRY,
    length_free: bool = False,
    outer_length: float | None = None,
) -> ForceBalance:
    """Fit the balance of forces to trials, with L [m] and g [m/s^2]: see `balance_of_pieces`."""
    mechanism = Mechanism(length, gravity, outer_length or length)
    pieces = pieces_of(trials, mechanism.time_unit)
    return balance_of_pieces(pieces, mechanism, effects=effects, optional=optional, length_free=length_free)


def pieces_of(trials: Sequence[Trial], time_unit: float) -> list[Piece]:
    """Return the smooth motion of the trials' stretches between gaps that are longer than a rig's time unit [s]."""
    stretches = [stretch for trial in trials for stretch in trial.stretches]
    return [
        Piece.of(trial, time_unit) for trial in stretches if len(trial.time) >= FEWEST and trial.duration > time_unit
    ]


def balance_of_pieces(
    pieces: Sequence[Piece],
    mechanism: Mechanism,
    *,
    effects: Sequence[TorqueEffect] = (),
    optional: Sequence[TorqueEffect] = DRY,
    length_free: bool = False,
    half_width: float | None = None,
) -> ForceBalance:
    """Fit the balance of forces to smooth motion.

    Args:
        pieces: the motion.
        mechanism: what is known of the pendulum.
        effects: torques of the catalogue to be found too.
        optional: more of them, of which the Bayesian information criterion chooses.
        length_free: whether L is sought too; the given one still sets the scale of time.
        half_width: of the windows [s]; by default what suits the noise.

    Where weights differ from trial to trial, A22 is found as well.

    Raises:
        IdentificationError: there is too little motion.
    """
    _refuse_a_joint_that_rests(pieces)
    inertia_free = len({piece.weights for piece in pieces}) > 1
    whole = Unknowns((*effects, *optional), length_free, inertia_free)
    # Torques on the rods may depend on the base parameters, which the others show.
    plain = replace(whole, effects=tuple(effect for effect in whole.effects if effect.form is not Form.RODS))
    choices = [replace(whole, effects=(*effects, *subset)) for subset in _subsets(optional)]
    known = dict[Unknowns, Regression]()
    if half_width is not None and plain == whole:
        rows = mechanism.rows(pieces, whole, half_width, np.zeros(len(GROUPS)))
    else:
        half_width, rows, fit = _in_windows_of_their_width(mechanism, pieces, plain, half_width)
        if plain == whole:
            known[whole] = fit
        else:
            inverse_inertia = fit.values[plain.names.index(INVERSE_INERTIA.symbol)] if inertia_free else 0.0
            rows = mechanism.rows(pieces, whole, half_width, fit.values[: len(GROUPS)], inverse_inertia)
    regressions = [known.get(unknowns) or _fit(_only(rows, whole, unknowns), unknowns) for unknowns in choices]
    criteria = [_criterion(regression, rows) for regression in regressions]
    chosen = int(np.argmin(criteria))
    unknowns, fit = choices[chosen], regressions[chosen]
    gravity_torque = np.maximum(mechanism.gravity_torque(unknowns, fit.values, pieces), _NO_TORQUE)
    return ForceBalance(
        unknowns=unknowns,
        values=fit.values,
        covariance=fit.covariance,
        criterion=criteria[chosen],
        unexplained=np.sqrt(np.diag(fit.scatter)) / gravity_torque,
        noise_share=_only(rows, whole, unknowns).noise(fit.values) / gravity_torque,
        used=rows.holds.mean(axis=0),
        windows=len(rows.holds),
        half_width=half_width,
        noise=np.sqrt(np.mean([np.diag(piece.motion.noise)[:2] for piece in pieces], axis=0)),
        length=mechanism.length_of(unknowns, fit.values),
    )


def _in_windows_of_their_width(
    mechanism: Mechanism, pieces: Sequence[Piece], unknowns: Unknowns, given: float | None
) -> tuple[float, Rows, Regression]:
    """Return the half width [s] that is given or suits the noise, and rows and fit with it."""
    unit = mechanism.time_unit
    fits = []
    for half_width in (given,) if given else (width * unit for width in _HALF_WIDTHS):
        rows = mechanism.rows(pieces, unknowns, half_width, np.zeros(len(GROUPS)))
        enough = rows.holds.mean(axis=1).sum() >= STEPS_BETWEEN * _FEWEST_ROWS * len(unknowns.names)
        if not enough or not rows.holds.any(axis=0).all():
            continue
        fits.append((half_width, rows, _fit(rows, unknowns)))
        if fits[-1][2].noise_share < _LITTLE_NOISE:
            break
    if not fits:
        raise IdentificationError(
            f"there is too little motion for a balance of forces: with L = {mechanism.length:g} m, some "
            f"{_HALF_WIDTHS[0] * _FEWEST_ROWS * len(unknowns.names) * unit:.1f} s are needed in which both joints move"
        )
    return min(fits, key=lambda found: found[2].noise_share)


def _refuse_a_joint_that_rests(pieces: Sequence[Piece]) -> None:
    for joint, name in enumerate(JOINTS):
        if pieces and not any(np.any(piece.motion.known & ~piece.resting[joint]) for piece in pieces):
            raise IdentificationError(
                f"the {name} joint does not move: its friction and the rods' inertias cannot be told apart; record "
                "trials in which it does"
            )


def _subsets(effects: Sequence[TorqueEffect]) -> list[tuple[TorqueEffect, ...]]:
    return [subset for count in range(len(effects) + 1) for subset in itertools.combinations(effects, count)]


def _only(rows: Rows, whole: Unknowns, part: Unknowns) -> Rows:
    """Return the rows with the columns of a part of the unknowns."""
    return replace(rows, columns=rows.columns[..., [whole.names.index(name) for name in part.names]])


def _fit(rows: Rows, unknowns: Unknowns) -> Regression:
    """Fit within limits; A33 is raised above what makes a mechanism with the A23 that was found."""
    lower, upper = unknowns.limits
    overlap = 2 * STEPS_BETWEEN
    fit = regress(rows.columns, rows.target, rows.holds, lower, upper, overlap, _A33)
    for _ in range(_ROUNDS):
        least = _MARGIN * fit.values[_A23] ** 2
        if fit.values[_A33] >= least * (1 - 1e-6):
            break
        if least > _LARGEST:
            raise IdentificationError("the balance of forces bounds no inertia: too little motion of the inner joint")
        lower[_A33] = least
        fit = regress(rows.columns, rows.target, rows.holds, lower, upper, overlap, _A33)
    return fit


def _criterion(fit: Regression, rows: Rows) -> float:
    """Return the Bayesian information criterion (Schwarz, 1978) of a fit, of rows that overlap.

    The outer rod's rows, whose target is zero, count as errors of its acceleration.
    """
    count = rows.holds.sum(axis=0) / STEPS_BETWEEN
    both = np.count_nonzero(rows.holds.all(axis=1)) / STEPS_BETWEEN
    variance = np.diag(fit.scatter)
    alike = fit.scatter[0, 1] ** 2 / np.prod(variance)
    of_acceleration = np.log(variance) - [0.0, np.log(max(fit.values[_A33] ** 2, np.finfo(float).tiny))]
    misfit = count @ of_acceleration + both * np.log(1.0 - alike)
    return float(misfit + len(fit.values) * np.log(max(count.sum(), 2.0)))
