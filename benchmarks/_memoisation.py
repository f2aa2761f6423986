"""A memory of what tracing computes, so that a variant of it costs only what it decides otherwise.

Refits and score tests follow from their arguments alone. While `memoised` lasts, each is computed once.
"""

import functools
import importlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import Window
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.evidence import Attempt

_COMPUTED = {
    "cdp_ident.tracing.addition": ("ScoreTest", "instants"),
    "cdp_ident.tracing.evidence": ("refine",),
    "cdp_ident.tracing.exchange": ("ScoreTest",),
    "cdp_ident.tracing.final_model": ("fit_initial_states",),
    "cdp_ident.tracing.progress": ("attempt_of", "refine", "refine_from_afar", "reweighted"),
    "cdp_ident.tracing.pruning": ("instants",),
    "cdp_ident.tracing.screening": ("ScoreTest",),
    "cdp_ident.tracing.stepwise": ("attempt_of",),
    "cdp_ident.tracing.trace": ("attempt_of",),
    "cdp_ident.tracing.unknown_torques": ("ScoreTest", "error_from_other_trials", "smooth_curve"),
}
"""What takes time, by the module that calls it."""
_DECIDED_BY = {"instants": ("AWAY", "FAMILY_LEVEL")}
"""The thresholds that decide within some of it."""


@contextmanager
def memoised() -> Iterator[None]:
    """Compute nothing twice in this process until the end of the context."""
    memories: dict[Any, Any] = {}
    before = []
    for name, functions in _COMPUTED.items():
        module = importlib.import_module(name)
        for function in functions:
            original = getattr(module, function)
            before.append((module, function, original))
            setattr(module, function, memories.setdefault(original, _memoised(original)))
    try:
        yield
    finally:
        for module, function, original in before:
            setattr(module, function, original)


def _memoised(function: Callable[..., Any]) -> Callable[..., Any]:
    results: dict[Any, tuple[Any, BaseException | None, Any]] = {}

    @functools.wraps(function, updated=())
    def once(*arguments: Any, **named: Any) -> Any:
        decided_by = [getattr(thresholds, name) for name in _DECIDED_BY.get(function.__name__, ())]
        key = _key((arguments, sorted(named.items()), decided_by))
        if key not in results:
            try:
                # What the key identifies is kept with it, so that no other object takes its place.
                results[key] = function(*arguments, **named), None, arguments
            except Exception as error:  # noqa: BLE001 - it is raised wherever the same is asked for
                results[key] = None, error, arguments
        result, failed, _ = results[key]
        if failed is not None:
            raise failed
        return result

    return once


def _key(value: Any) -> Any:
    """Return what stands for an argument: its content, or itself where that is large."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if isinstance(value, list | tuple):
        return tuple(map(_key, value))
    return id(value) if isinstance(value, Fit | Window | Attempt) else value
