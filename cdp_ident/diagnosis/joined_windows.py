"""Values for which each window ends where the next one begins.

Windows are fitted with initial states of their own, as if each were a trial by itself. That a window begins where the
one before it ended is known besides, if the model holds; its values and their covariance are conditioned on that
(matching conditions: Bock, Recent advances in parameter identification techniques for ODE, 1983). The jumps between
windows are linear in the errors of values and initial states, so this takes one step.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc

from cdp_ident.diagnosis.continuity import at_times, followed, initial_state
from cdp_ident.diagnosis.uncertainty import scaled_inverse
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.layout import RODS_STATES

Array = npt.NDArray[np.float64]

_CERTAIN = 1e-10
"""Directions of jumps with less than this share of the largest variance are certain, such as the speed of a joint that
sticks."""
_SHARE_OF_STEP = 0.01
"""Speeds are taken over so much of a step of the integrator to either side."""
_MOST_REMEMBERED = 2.0
"""Integrated autocorrelation time [samples] beyond which the noise at a window's end is still there in the next one."""
_MOST = 500
"""Jumps that are used, of more evenly spread ones: the time goes with their third power."""
_LEVEL = 0.01
"""Probability of such jumps from which on windows join."""


@dataclass(frozen=True)
class Jumps:
    """The jumps from the end of each window to the beginning of the next, and what they say about the values."""

    p_value: float
    """Probability of larger jumps where the model holds."""
    values: Array
    """(unknowns,) values for which there are no jumps."""
    covariance: Array
    """(unknowns, unknowns) of these."""

    @property
    def join(self) -> bool:
        """Whether the jumps are no larger than uncertain initial states and values make them."""
        return self.p_value > _LEVEL


def jumps(fit: Fit, spread: Array) -> Jumps | None:
    """Return the jumps of a fit; None where no windows follow one another, or effects have states of their own.

    Windows that do not show all of their initial state, as where a joint rests, are left out. With noise that is
    remembered for samples there are none either: it goes on from one window to the next.

    Args:
        fit: a fit.
        spread: (unknowns, unknowns) covariance of its values.
    """
    remembered = fit.autocorrelation.integrated_time
    if fit.model.states > RODS_STATES or remembered > _MOST_REMEMBERED or not np.all(np.isfinite(spread)):
        return None
    size, unknowns = RODS_STATES, len(fit.values)
    states = [initial_state(fit, index) for index in range(len(fit.windows))]
    known = [np.all(np.diag(of_state) > 0.0) for of_state, _ in states]
    following = [index for index in followed(fit) if known[index] and known[index + 1]]
    if not following:
        return None
    following = following[:: -(-len(following) // _MOST)]
    # Correlated noise makes initial states as uncertain as it makes a mean.
    variance = fit.variance * remembered
    found, by_values = np.zeros((len(following), size)), np.zeros((len(following), size, unknowns))
    of_states = np.zeros((len(following), size, len(following), size))
    carried_before: tuple[int, Array] | None = None
    for row, index in enumerate(following):
        arrival, carried, directly = _arrival(fit, index)
        (of_this, this_by_values), (of_next, next_by_values) = states[index], states[index + 1]
        found[row] = fit.windows[index + 1].start[:size] - arrival
        by_values[row] = next_by_values - carried @ this_by_values - directly
        of_states[row, :, row] = variance * (carried @ of_this @ carried.T + of_next)
        if carried_before and carried_before[0] == index - 1:
            shared = -variance * carried @ of_this
            of_states[row, :, row - 1], of_states[row - 1, :, row] = shared, shared.T
        carried_before = (index, carried)
    gap, slope = found.ravel(), by_values.reshape(-1, unknowns)
    expected = slope @ spread @ slope.T + of_states.reshape(len(gap), len(gap))
    inverse, certain = scaled_inverse(expected, _CERTAIN)
    gain = spread @ slope.T @ inverse
    covariance = spread - gain @ slope @ spread
    return Jumps(
        p_value=float(chdtrc(len(gap) - certain.shape[1], gap @ inverse @ gap)),
        values=fit.values - gain @ gap,
        covariance=(covariance + covariance.T) / 2.0,
    )


def _arrival(fit: Fit, index: int) -> tuple[Array, Array, Array]:
    """Return the state (4,) in which a window ends where the next begins, and its derivatives by start and values."""
    window, after = fit.windows[index], fit.windows[index + 1]
    rods, of_rods = fit.model.with_exact_encoders()
    apart = _SHARE_OF_STEP * window.grid.step
    time = after.begin - window.begin + np.array([-apart, 0.0, apart])
    angles, sensitivity = rods.predict(fit.values[of_rods], window.start, at_times(window, time))

    def state(of_angles: Array) -> Array:
        return np.concatenate([of_angles[1], (of_angles[2] - of_angles[0]) / (2.0 * apart)])

    by_all = state(sensitivity)
    directly = np.zeros((RODS_STATES, len(fit.values)))
    directly[:, of_rods] = by_all[:, RODS_STATES:]
    return state(angles), by_all[:, :RODS_STATES], directly
