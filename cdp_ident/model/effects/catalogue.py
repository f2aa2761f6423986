"""All effects that are searched for. Adding one here adds it to the fit, the report, the simulation and ROS."""

from collections.abc import Sequence

from cdp_ident.model.compilation import Compilable, part
from cdp_ident.model.effects.effect import Effect, TorqueEffect
from cdp_ident.model.effects.encoders import ENCODERS
from cdp_ident.model.effects.forces import FORCES
from cdp_ident.model.effects.friction import FRICTION, UNEVENNESS

CATALOGUE: tuple[Effect, ...] = (*FRICTION, *FORCES, *ENCODERS)

_ALL = (*CATALOGUE, *UNEVENNESS)
_TORQUES = tuple(dict.fromkeys(effect.torque for effect in _ALL if isinstance(effect, TorqueEffect)))
"""Each compiled torque once, though several effects may share it."""


def kind_of(effect: TorqueEffect) -> int:
    """Return the number by which compiled code knows the effect's torque."""
    return _TORQUES.index(effect.torque)


def _dispatcher(torques: Sequence[Compilable], first: int) -> Compilable:
    """Return a compiled function that calls one of the torques by its number: a tree of comparisons."""
    if len(torques) == 1:
        torque = torques[0]

        def call(kind, theta1, theta2, omega1, omega2, time, values, row, constants):
            return torque(theta1, theta2, omega1, omega2, time, values, row, constants)

        return part(_named(call, f"torque_{first}"))
    middle = len(torques) // 2
    lower, upper = _dispatcher(torques[:middle], first), _dispatcher(torques[middle:], first + middle)

    def choose(kind, theta1, theta2, omega1, omega2, time, values, row, constants):
        if kind < first + middle:
            return lower(kind, theta1, theta2, omega1, omega2, time, values, row, constants)
        return upper(kind, theta1, theta2, omega1, omega2, time, values, row, constants)

    return part(_named(choose, f"torques_{first}_to_{first + len(torques) - 1}"))


def _named(function: Compilable, name: str) -> Compilable:
    """Give a function a name of its own.

    numba's linker knows a compiled function by its name and by a number counted from the process's start. Loops that
    are kept on disk were compiled in other processes: of two functions of one name it would take one for the other.
    """
    function.__name__ = function.__qualname__ = name
    return function


effect_torque = _dispatcher(_TORQUES, 0)
"""Compiled: the number of a torque (`kind_of`), then what every `TorqueEffect.torque` takes."""
