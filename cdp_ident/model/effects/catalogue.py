"""All effects that are searched for. Adding one here adds it to the fit, the report, the simulation and ROS."""

from collections.abc import Callable, Sequence

from cdp_ident.model.compilation import Compilable, part
from cdp_ident.model.effects.bending import ROD_FLEX
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.effects.effect import Effect, Form, SensorEffect, TorqueEffect
from cdp_ident.model.effects.encoders import ENCODERS
from cdp_ident.model.effects.forces import FORCES
from cdp_ident.model.effects.friction import FRICTION

CATALOGUE: tuple[Effect, ...] = (*FRICTION, *FORCES, *ENCODERS, ROD_FLEX, *CURVES)

_LAWS = {
    form: tuple(
        dict.fromkeys(
            effect.law
            for effect in CATALOGUE
            if isinstance(effect, TorqueEffect) and effect.form is form and effect.law is not None
        )
    )
    for form in (Form.JOINT, Form.RODS, Form.MEMORY, Form.CURVE)
}
"""Each compiled law of torques once, though several effects may share it."""
_SENSOR_LAWS = tuple(
    dict.fromkeys(effect.law for effect in CATALOGUE if isinstance(effect, SensorEffect) and effect.law is not None)
)
"""Each compiled law of encoders once."""


def kind_of(effect: Effect) -> int:
    """Return the number by which compiled code knows the effect's law, among those of its form or of encoders."""
    if effect.law is None:
        return 0
    return (_SENSOR_LAWS if isinstance(effect, SensorEffect) else _LAWS[effect.form]).index(effect.law)


def _dispatcher(laws: Sequence[Compilable], name: str, first: int = 0) -> Compilable:
    """Return a compiled function that calls one of the laws by its number: a tree of comparisons.

    Args:
        laws: of one form, which take the same arguments.
        name: what the form's laws are laws of.
        first: number of the first law.
    """
    if len(laws) == 1:
        law = laws[0]

        def call(kind, *arguments):
            return law(*arguments)

        return part(_named(call, f"{name}_law_{first}"))
    middle = len(laws) // 2
    lower, upper = _dispatcher(laws[:middle], name, first), _dispatcher(laws[middle:], name, first + middle)

    def choose(kind, *arguments):
        if kind < first + middle:
            return lower(kind, *arguments)
        return upper(kind, *arguments)

    return part(_named(choose, f"{name}_laws_{first}_to_{first + len(laws) - 1}"))


def _named(function: Compilable, name: str) -> Compilable:
    """Give a function a name of its own.

    numba's linker knows a compiled function by its name and by a number counted from the process's start. Loops that
    are kept on disk were compiled in other processes: of two functions of one name it would take one for the other.
    """
    function.__name__ = function.__qualname__ = name
    return function


def in_loops(form: Form, loop_of: Callable[[Compilable, bool], Compilable], name: str) -> Compilable:
    """Return a compiled function that calls a loop of one of the laws of a form by the law's number.

    Args:
        form: of the laws.
        loop_of: makes a loop of a law, given that and whether it is the size of a dry friction.
        name: what the loops are loops of.
    """
    dry = {effect.law: effect.dry for effect in CATALOGUE if isinstance(effect, TorqueEffect)}
    loops = [part(_named(loop_of(law, dry[law]), f"{name}_loop_{k}")) for k, law in enumerate(_LAWS[form])]
    return _dispatcher(loops, f"{name}_loop_of")


joint_law = _dispatcher(_LAWS[Form.JOINT], "joint")
"""Compiled: the number of a law (`kind_of`), then what every law of form JOINT takes."""
rods_law = _dispatcher(_LAWS[Form.RODS], "rods")
"""Compiled: the number of a law (`kind_of`), then what every law of form RODS takes."""
memory_law = _dispatcher(_LAWS[Form.MEMORY], "memory")
"""Compiled: the number of a law (`kind_of`), then what every law of form MEMORY takes."""
curve_law = _dispatcher(_LAWS[Form.CURVE], "curve")
"""Compiled: the number of a law (`kind_of`), then what every law of form CURVE takes."""
sensor_law = _dispatcher(_SENSOR_LAWS, "sensor")
"""Compiled: the number of a law (`kind_of`), then what every law of an encoder takes."""
