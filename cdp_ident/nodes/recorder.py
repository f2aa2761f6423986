"""Records free-swing trials as rosbag2 bags, one bag a trial."""

from typing import Any

import rclpy.clock
import rclpy.qos
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from cdp_ident.bag.joint_state import MESSAGE_TYPE
from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.errors import RigError
from cdp_ident.outside_text import shown
from cdp_ident.rig.recording.facts import DIAGNOSTICS_TYPE, JointNames
from cdp_ident.rig.recording.recorder import FLUSH_NS, Recorder, RecorderOptions
from cdp_ident.ros.node import Parameters, parse_arguments, run_node
from cdp_ident.ros.topics import latched
from cdp_ident.ros.trial_limits import declare_trial_limits
from cdp_ident.user_input import user_path

DESCRIPTION = """\
Record free-swing trials. Armed, it waits until the pendulum is held away from hanging and let go, records until it is
at rest, and writes one rosbag2 bag (MCAP) a trial: the joint states and diagnostics from a moment before the release
on, and what is known of the trial as metadata. It tells when a trial is of little use: not zero-input, samples lost,
too short. Killed in the middle, it completes the bag at its next start.

subscribes  joint_states (sensor_msgs/JointState), /diagnostics (diagnostic_msgs/DiagnosticArray)
publishes   ~/state (std_msgs/String, latched)  idle, armed or recording
            ~/bag (std_msgs/String, latched)    folder of the last finished bag
serves      ~/arm    (std_srvs/Trigger)  wait for the release
            ~/start  (std_srvs/Trigger)  record now, release or not
            ~/stop   (std_srvs/Trigger)  end the trial, or the waiting for one"""

EXAMPLE = """\
example:
  ros2 run cdp_ident recorder --ros-args -p folder:=bags -p rearm:=true"""


class RecorderNode:
    """The recorder on its node."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters) -> None:
        self._node = node
        self._clock = node.get_clock()
        options = _declare_options(parameters)
        parameters.start()
        self._state = node.create_publisher(String, "~/state", latched())
        self._bag = node.create_publisher(String, "~/bag", latched())
        self._recorder = Recorder(
            options,
            say=lambda sentence: node.get_logger().info(shown(sentence)),
            on_state=lambda state: self._state.publish(String(data=state)),
            on_bag=lambda folder: self._bag.publish(String(data=str(folder))),
        )
        reliable = rclpy.qos.QoSProfile(depth=5000, reliability=rclpy.qos.ReliabilityPolicy.RELIABLE)
        self._subscribe(JointState, MESSAGE_TYPE, "joint_states", reliable)
        self._subscribe(DiagnosticArray, DIAGNOSTICS_TYPE, "/diagnostics", 10)
        node.create_service(Trigger, "~/arm", self._arm)
        node.create_service(Trigger, "~/start", self._start)
        node.create_service(Trigger, "~/stop", self._stop)
        # Steady: it goes on where use_sim_time is set and no clock runs.
        self._steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        node.create_timer(FLUSH_NS * 1e-9, lambda: self._recorder.tick(self._now()), clock=self._steady)

    def close(self) -> None:
        """Complete the bag that is being recorded."""
        self._recorder.close()

    def _subscribe(self, message_class: type, message_type: str, topic: str, profile: Any) -> None:
        name = self._node.resolve_topic_name(topic)

        def take(raw: bytes) -> None:
            self._recorder.take(name, message_type, self._now(), raw)

        self._node.create_subscription(message_class, topic, take, profile, raw=True)

    def _now(self) -> int:
        return int(self._clock.now().nanoseconds)

    def _arm(self, _request: Any, response: Any) -> Any:
        return self._answer(response, self._recorder.arm)

    def _start(self, _request: Any, response: Any) -> Any:
        return self._answer(response, lambda: self._recorder.start(self._now()))

    def _stop(self, _request: Any, response: Any) -> Any:
        return self._answer(response, self._recorder.stop)

    def _answer(self, response: Any, action: Any) -> Any:
        try:
            result = action()
            response.success, response.message = True, str(result or self._recorder.state)
        except RigError as error:
            response.success, response.message = False, str(error)
            self._node.get_logger().warning(str(error))
        return response


def _declare_options(parameters: Parameters) -> RecorderOptions:
    joints = JointNames()

    def number(name: str, default: float, description: str, unit: str, maximum: float) -> float:
        return parameters.declare(name, default, description, unit=unit, minimum=0.0, maximum=maximum)

    return RecorderOptions(
        folder=user_path(parameters.declare("folder", "trials", "where bags go")),
        name=parameters.declare("name", "trial", "what names of bags begin with; the time follows"),
        joints=JointNames(
            cart=parameters.declare("cart_joint", joints.cart, "name of the cart's joint; may be missing in messages"),
            inner=parameters.declare("inner_joint", joints.inner, "name of the joint between cart and inner rod"),
            outer=parameters.declare("outer_joint", joints.outer, "name of the joint between the rods"),
        ),
        limits=declare_trial_limits(parameters),
        pre_trigger=number("pre_trigger", 1.0, "how much from before the release is kept", "s", 60.0),
        cart_limit=number("cart_limit", 0.002, "with more motion of the cart a trial is not zero-input", "m", 10.0),
        shortest=number("shortest", 5.0, "a shorter trial is of little use", "s", 3600.0),
        rearm=parameters.declare("rearm", False, "arm at the start and after each trial without being asked"),
    )


@entry_point
def main(arguments: list[str]) -> int:
    """Run the recorder."""
    parse_arguments(ArgumentParser("recorder", DESCRIPTION, EXAMPLE), arguments)
    return run_node("recorder", RecorderNode, arguments)
