"""All effects that are searched for. Adding one here adds it to the fit, the report, the simulation and ROS."""

from collections.abc import Sequence

from cdp_ident.model.compilation import Compilable, part
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.effects.effect import Effect, Form, TorqueEffect
from cdp_ident.model.effects.encoders import ENCODERS
from cdp_ident.model.effects.forces import FORCES
from cdp_ident.model.effects.friction import FRICTION

CATALOGUE: tuple[Effect, ...] = (*FRICTION, *FORCES, *ENCODERS, *CURVES)

_LAWS = {
    form: tuple(
        dict.fromkeys(
            effect.law
            for effect in CATALOGUE
            if isinstance(effect, TorqueEffect) and effect.form is form and effect.law is not None
        )
    )
    for form in (Form.JOINT, Form.RODS, Form.MEMORY)
}
"""Each compiled law once, though several effects may share it."""


def kind_of(effect: TorqueEffect) -> int:
    """Return the number by which compiled code knows the effect's law, among those of its form."""
    return _LAWS[effect.form].index(effect.law) if effect.law is not None else 0


def _joint_dispatcher(laws: Sequence[Compilable], first: int) -> Compilable:
    """Return a compiled function that calls one of the laws of joints by its number: a tree of comparisons."""
    if len(laws) == 1:
        law = laws[0]

        def call(kind, angle, speed, values, row, slopes):
            return law(angle, speed, values, row, slopes)

        return part(_named(call, f"joint_law_{first}"))
    middle = len(laws) // 2
    lower, upper = _joint_dispatcher(laws[:middle], first), _joint_dispatcher(laws[middle:], first + middle)

    def choose(kind, angle, speed, values, row, slopes):
        if kind < first + middle:
            return lower(kind, angle, speed, values, row, slopes)
        return upper(kind, angle, speed, values, row, slopes)

    return part(_named(choose, f"joint_laws_{first}_to_{first + len(laws) - 1}"))


def _rods_dispatcher(laws: Sequence[Compilable], first: int) -> Compilable:
    """Return a compiled function that calls one of the laws of rods by its number."""
    if len(laws) == 1:
        law = laws[0]

        def call(kind, state, time, values, row, constants, slopes):
            return law(state, time, values, row, constants, slopes)

        return part(_named(call, f"rods_law_{first}"))
    middle = len(laws) // 2
    lower, upper = _rods_dispatcher(laws[:middle], first), _rods_dispatcher(laws[middle:], first + middle)

    def choose(kind, state, time, values, row, constants, slopes):
        if kind < first + middle:
            return lower(kind, state, time, values, row, constants, slopes)
        return upper(kind, state, time, values, row, constants, slopes)

    return part(_named(choose, f"rods_laws_{first}_to_{first + len(laws) - 1}"))


def _memory_dispatcher(laws: Sequence[Compilable], first: int) -> Compilable:
    """Return a compiled function that calls one of the laws with a memory by its number."""
    if len(laws) == 1:
        law = laws[0]

        def call(kind, speed, own, values, row, slopes):
            return law(speed, own, values, row, slopes)

        return part(_named(call, f"memory_law_{first}"))
    middle = len(laws) // 2
    lower, upper = _memory_dispatcher(laws[:middle], first), _memory_dispatcher(laws[middle:], first + middle)

    def choose(kind, speed, own, values, row, slopes):
        if kind < first + middle:
            return lower(kind, speed, own, values, row, slopes)
        return upper(kind, speed, own, values, row, slopes)

    return part(_named(choose, f"memory_laws_{first}_to_{first + len(laws) - 1}"))


def _named(function: Compilable, name: str) -> Compilable:
    """Give a function a name of its own.

    numba's linker knows a compiled function by its name and by a number counted from the process's start. Loops that
    are kept on disk were compiled in other processes: of two functions of one name it would take one for the other.
    """
    function.__name__ = function.__qualname__ = name
    return function


joint_law = _joint_dispatcher(_LAWS[Form.JOINT], 0)
"""Compiled: the number of a law (`kind_of`), then what every law of form JOINT takes."""
rods_law = _rods_dispatcher(_LAWS[Form.RODS], 0)
"""Compiled: the number of a law (`kind_of`), then what every law of form RODS takes."""
memory_law = _memory_dispatcher(_LAWS[Form.MEMORY], 0)
"""Compiled: the number of a law (`kind_of`), then what every law of form MEMORY takes."""
