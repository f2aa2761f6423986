# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model as parameters: a node's own, or those that another node serves, followed as they change."""

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, SupportsFloat

from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future
from std_msgs.msg import String

from cdp_ident.configuration.described import Described
from cdp_ident.configuration.fitted_model import (
    EFFECT_PREFIX,
    GROUP_PREFIX,
    OF_MECHANISM,
    OUTER_ROD_LENGTH,
    FittedModel,
    describes_model,
    fitted_model,
    follows_from_physical_values,
)
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.own import OWN_EFFECTS
from cdp_ident.model.parameters import GROUPS, INERTIA, NOMINAL
from cdp_ident.ros.node import call_every
from cdp_ident.ros.parameters import Parameters
from cdp_ident.ros.topics import latched

_LOOK_SECONDS = 0.1
"""How often it is looked whether there is something to ask for [s]."""
_ANSWER_SECONDS = 5.0
"""A node that has not answered for so long [s] is asked again: it may have been started anew."""


class ModelParameters:
    """Keeps a node's parameters and the model that they describe the same."""

    def __init__(self, node: Any, parameters: Parameters, source: str, take: Callable[[FittedModel], None]) -> None:
        """`source` is the node that the parameters follow, if any; `take` is given each new model."""
        self._parameters, self._source, self._take = parameters, source, take
        self._shown: dict[str, Any] = {}
        self._from_inside = False
        parameters.check_changes(self._changed)
        node.add_post_set_parameters_callback(self._follow)

    def show(self, values: Mapping[str, Any]) -> None:
        """Make the model of `values` the node's; raises `OptionError` where they describe none."""
        self._show(values, self._model(values))

    def _model(self, values: Mapping[str, Any]) -> FittedModel:
        return fitted_model(values, f"the parameters of {self._source}" if self._source else "the parameters")

    def _show(self, values: Mapping[str, Any], model: FittedModel) -> None:
        groups = {f"{GROUP_PREFIX}{group.symbol}": float(x) for group, x in zip(GROUPS, model.values, strict=False)}
        effects = {name: value for name, value in values.items() if name.startswith((EFFECT_PREFIX, OWN_EFFECTS))}
        new: dict[str, Any] = {**model.physical, **groups, OUTER_ROD_LENGTH: model.motion.mechanism.outer_length}
        new[INERTIA.symbol] = model.motion.mechanism.inertia
        new |= {name: _of_ros(value) for name, value in effects.items()}
        if new == self._shown:
            return
        self._from_inside = True
        try:
            changeable = not self._source
            shown = [Described(name, value, *_described(name), changeable=changeable) for name, value in new.items()]
            self._parameters.show(shown, gone=self._shown.keys() - new.keys())
        finally:
            self._from_inside = False
        self._shown = new
        self._take(model)

    def _follow(self, parameters: list[Any]) -> None:
        if changed := self._changed(parameters):
            self._show(*changed)

    def _changed(self, parameters: list[Any]) -> tuple[dict[str, Any], FittedModel] | None:
        """Return what a change from outside makes of the values, and the model; None where it is about other things.

        Physical values bring their base parameters and A22 with them, but these the physical values not.
        """
        changes = {parameter.name: parameter.value for parameter in parameters if parameter.name in self._shown}
        if self._from_inside or not changes:
            return None
        values = self._shown | changes
        if changes.keys() & NOMINAL.keys():
            values = {n: x for n, x in values.items() if n in changes or not follows_from_physical_values(n)}
        return values, self._model(values)


def own_values(given: Mapping[str, Any], fitted: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a model that a node was given: by ROS, before it by a fitted model's file, else Table 2.

    Physical values given by ROS bring their base parameters and A22 with them, whatever the file has.
    """
    own = {name: value for name, value in given.items() if describes_model(name)}
    if own.keys() & NOMINAL.keys():
        fitted = {name: value for name, value in fitted.items() if not follows_from_physical_values(name)}
    return NOMINAL | dict(fitted) | own


def _of_ros(value: Any) -> str | float | list[float]:
    """Return a value of an effect as ROS has it."""
    if isinstance(value, str):
        return value
    return float(value) if isinstance(value, SupportsFloat) else [float(number) for number in value]


def _described(name: str) -> tuple[str, str]:
    """Return the description and the unit of a parameter."""
    if name in OF_MECHANISM:
        return OF_MECHANISM[name]
    effect_name, joint, *_, parameter_name = name.removeprefix(EFFECT_PREFIX).split(".")
    effect = next(effect for effect in known_effects() if (effect.name, effect.joint) == (effect_name, joint))
    unit = next((parameter.unit for parameter in effect.parameters if parameter.name == parameter_name), "")
    return f"{effect.description}: {parameter_name}", unit


class ParameterSource:
    """Reads a node's model as soon as it serves one, and again whenever its parameters change."""

    def __init__(self, node: Any, source: str, take: Callable[[dict[str, Any]], None]) -> None:
        """`source` is the other node's full name; `take` is given its parameters that describe the model, by name."""
        self._source, self._take = source, take
        self._client = AsyncParameterClient(node, source)
        self._changed, self._asked_at = True, 0.0
        self._answer: Future | None = None
        """What is waited for."""
        node.create_subscription(ParameterEvent, "/parameter_events", self._note_event, 1000)
        node.create_subscription(String, f"{source}/state", self._note, latched())
        call_every(node, _LOOK_SECONDS, self._look)

    def _note_event(self, event: Any) -> None:
        if event.node == self._source:
            self._changed = True

    def _note(self, _message: Any) -> None:
        # A node that comes, or whose result is ready, may have done so before its events could be heard.
        self._changed = True

    def _look(self) -> None:
        if self._answer and time.monotonic() - self._asked_at > _ANSWER_SECONDS:
            unanswered, self._answer, self._changed = self._answer, None, True
            unanswered.cancel()
        if self._changed and self._answer is None and self._client.services_are_ready():
            self._changed, self._asked_at = False, time.monotonic()
            self._answer = self._client.list_parameters(callback=self._listed)

    def _listed(self, answer: Future) -> None:
        if answer is self._answer:
            names = [name for name in answer.result().result.names if describes_model(name)]
            self._answer = self._client.get_parameters(names, partial(self._got, names))

    def _got(self, names: list[str], answer: Future) -> None:
        if answer is not self._answer:
            return
        self._answer, values = None, answer.result().values
        if len(values) != len(names) or any(value.type == ParameterType.PARAMETER_NOT_SET for value in values):
            self._changed = True  # in between they became others
        elif not self._changed:
            self._take({n: parameter_value_to_python(value) for n, value in zip(names, values, strict=True)})
