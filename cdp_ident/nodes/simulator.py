# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shows how the fitted model moves: beside a recorded trial, beside the live rig, or alone."""

from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.configuration.fitted_model import FittedModel, describes_model, fitted_model
from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import KEYS, Settings
from cdp_ident.errors import OptionError
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.nodes.showing import FramePublisher, Playing, Shadowing
from cdp_ident.replay.player import Pace
from cdp_ident.replay.scene import Free, Replay, Scene, Start
from cdp_ident.replay.shadow import DEFAULT_LEAD
from cdp_ident.rig.recording.detector import TrialLimits
from cdp_ident.ros.model_parameters import ModelParameters, ParameterSource, own_values
from cdp_ident.ros.node import parse_arguments, run_node, serve
from cdp_ident.ros.parameters import Parameters
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions

DESCRIPTION = """\
Simulate the fitted model, its effects included, and show what the encoders would show. Its parameters come from a
running identify (-p source:=/identify, followed as it changes), from fitted.yaml (--fitted), or are its own, which can
be changed while it runs.

modes      replay  the motion of a trial (--bag), measured and simulated from the same start, in step
           free    the model alone, from start.* on; a change of start.* begins anew from there
           shadow  beside the live rig (joint_states): from each release until the pendulum rests or is caught
                   a measured cart is an input, as are motors' efforts (trial.input)
publishes  simulated/joint_states (sensor_msgs/JointState)
           measured/joint_states  (sensor_msgs/JointState)  in replay
           simulated/error        (sensor_msgs/JointState)  in replay and shadow: simulated less measured [rad]
           /clock                 (rosgraph_msgs/Clock)     with clock:=true
           ~/state                (std_msgs/String, latched)
serves     ~/reset ~/pause ~/resume (std_srvs/Trigger)

`ros2 param describe /simulator NAME` describes a parameter; config/simulator.yaml lists all."""

EXAMPLE = """\
examples:
  ros2 run cdp_ident simulator --bag bags/swing_wide --fitted identification/swing_wide/fitted.yaml
  ros2 run cdp_ident simulator --bag bags/swing_wide --ros-args -p source:=/identify -p rate:=0.25
  ros2 run cdp_ident simulator --ros-args -p mode:=shadow -p source:=/identify
  ros2 run cdp_ident simulator --ros-args -p start.inner:=1.5 -p effects.coulomb_friction.outer.torque:=0.002"""

NODE_NAME = "simulator"
_START = "start."
_TRIAL = "trial."


class Simulator:
    """The simulator on its node."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters, bag: Path | None, fitted: Path | None, once: bool) -> None:
        self._node, self._parameters = node, parameters
        mode = parameters.declare(
            "mode", "replay" if bag else "free", "what is shown", choices=("replay", "free", "shadow")
        )
        source = _declare_source(node, parameters)
        pace = parameters.declare_fields(Pace(loop=not once))
        parameters.declare_fields(Start(), _START)
        trial_options = _declare_trial_options(parameters)
        limits = parameters.declare_fields(TrialLimits())
        lead = parameters.declare(
            "lead", DEFAULT_LEAD, "shadow: so much after a release the start is fitted to", unit="s", minimum=0.1,
            maximum=10.0,
        )  # fmt: skip
        velocities = parameters.declare(
            "velocities", False, "joint states have velocities, estimated by the model as the driver does"
        )
        _refuse_contradictions(parameters, mode, source, bag, fitted, once)
        self._frames = FramePublisher(node, mode == "replay", mode != "free", pace.clock, velocities)
        self._show: Playing | Shadowing
        if mode == "shadow":
            self._show = Shadowing(node, self._frames, trial_options, limits, lead)
        else:
            scene = self._replayed(bag, trial_options) if bag else self._free
            self._show = Playing(node.get_clock(), self._frames, pace, once, scene, self._end)
        self._model = ModelParameters(node, parameters, source, self._take_model)
        if source:
            if own := [name for name in parameters.given() if describes_model(name)]:
                node.get_logger().warning(
                    f"{', '.join(own[:3])}{' …' if own[3:] else ''}: {source} has them, passed over"
                )
            self._frames.say(f"waiting for the parameters of {source}")
            self._source = ParameterSource(node, source, self._take_from_source)
        else:
            values = {}
            if fitted:
                values = read_parameter_file(fitted, NODE_NAME).taken()
                fitted_model(values, str(fitted))  # complete by itself
            self._model.show(own_values(parameters.given(), values))
        parameters.will_show(describes_model)
        parameters.start()
        node.add_post_set_parameters_callback(self._follow)
        for action in (self._show.reset, self._show.pause, self._show.resume):
            serve(node, f"~/{action.__name__}", partial(self._after, action))
        self._show.start()

    def close(self) -> None:
        """Stop, and let everything arrive that was shown."""
        self._show.close()
        self._frames.close()

    def _end(self, exit_code: int) -> None:
        self.exit_code = exit_code

    def _replayed(self, bag: Path, options: TrialOptions) -> Callable[[FittedModel], Scene]:
        trial = load_trial(bag, options)
        for note in trial.notes:
            self._node.get_logger().info(f"{trial.name}: {note}")
        return lambda model: Replay(trial, model)

    def _free(self, model: FittedModel) -> Scene:
        start = {field.name: self._parameters.get(f"{_START}{field.name}") for field in fields(Start)}
        return Free(Start(**start), model)

    def _take_model(self, model: FittedModel) -> None:
        self._frames.take_model(model)
        self._show.take_model(model)

    def _take_from_source(self, values: dict[str, Any]) -> None:
        if not NOMINAL.keys() <= values.keys():
            return  # it has no result yet
        try:
            self._model.show(values)
        except OptionError as error:
            self._node.get_logger().error(f"the parameters are still those of before: {error}")

    def _follow(self, changed: list[Any]) -> None:
        if not isinstance(self._show, Playing):
            return
        if pace := {parameter.name: parameter.value for parameter in changed if parameter.name in ("rate", "loop")}:
            self._show.take_pace(pace)
        if any(parameter.name.startswith(_START) for parameter in changed):
            self._show.begin_anew()

    def _after(self, action: Callable[[], None]) -> str:
        action()
        self._frames.say(self._show.state)
        return self._show.state


def _declare_source(node: Any, parameters: Parameters) -> str:
    source = parameters.declare("source", "", "node whose parameters are taken and followed, such as /identify")
    if not source or source.startswith("/"):
        return source
    return f"{node.get_namespace().rstrip('/')}/{source}"


def _declare_trial_options(parameters: Parameters) -> TrialOptions:
    """Declare the conventions of the bag's or rig's joints, with the keys of `identify`."""
    given = {name: value for name, value in parameters.given().items() if name.startswith(_TRIAL) and name in KEYS}
    settings = Settings.of(given)
    values = {name: value for name, value in settings.values().items() if name.startswith(_TRIAL)}
    parameters.show(replace(KEYS[name], value=value) for name, value in values.items())
    return settings.trial


def _refuse_contradictions(
    parameters: Parameters, mode: str, source: str, bag: Path | None, fitted: Path | None, once: bool
) -> None:
    if (mode == "replay") != (bag is not None):
        advice = "it goes with mode replay only" if bag else "name the bag to be replayed by it"
        raise OptionError(f"mode is {mode} and --bag is {'' if bag else 'not '}given: {advice}")
    if once and mode != "replay":
        raise OptionError(
            f"--once ends with the trial that is replayed, and mode is {mode}: leave it out, or give --bag"
        )
    if once and parameters.get("loop"):
        raise OptionError("--once plays the trial once, and loop is true: leave one out")
    if source and fitted:
        raise OptionError("source and --fitted are both given: give one place for the parameters")
    if parameters.get("clock") and (parameters.get("use_sim_time") or mode == "shadow"):
        other = "use_sim_time" if parameters.get("use_sim_time") else "mode shadow"
        raise OptionError(f"clock and {other} are both given: time comes from one place only")


@entry_point
def main(arguments: list[str]) -> int:
    """Run the simulator."""
    options = parse_arguments(_parser(), arguments)
    given = (options.bag, options.fitted, options.once)
    return run_node(NODE_NAME, lambda node, parameters: Simulator(node, parameters, *given), arguments)


def _parser() -> ArgumentParser:
    parser = ArgumentParser(NODE_NAME, DESCRIPTION, EXAMPLE)
    parser.add_argument("--bag", type=Path, metavar="DIR", help="replay the trial of this rosbag2 bag")
    parser.add_argument("--fitted", type=Path, metavar="FILE", help="fitted.yaml of an identification")
    parser.add_argument("--once", action="store_true", help="end after the trial was replayed once")
    return parser
