# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the simulator shows: a replay or a free motion, played at absolute deadlines, or a motion beside a live rig."""

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from cdp_ident.command_line import EXIT_BAD_INPUT
from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.errors import CdpIdentError
from cdp_ident.replay.observer import Observer
from cdp_ident.replay.player import Pace, Player, RateTimer
from cdp_ident.replay.scene import Frame, Scene
from cdp_ident.replay.shadow import Shadow
from cdp_ident.rig.joints import Triple
from cdp_ident.rig.recording.detector import TrialLimits
from cdp_ident.rig.recording.facts import JointNames, PositionReader
from cdp_ident.ros.topics import JointStatePublisher, Subscription, latched
from cdp_ident.trial.options import TrialOptions

JOINTS = ("cart_joint", "inner_joint", "outer_joint")
_IDLE = 0.05
"""How long the thread sleeps while there is nothing to play, if nobody wakes it [s]."""
_LISTENERS_WITHIN = 5.0
"""What is played once begins when somebody listens, or after so long without [s]."""
_LONGEST_SLEEP = 0.01
"""It looks at the clock this often [s]: one that is simulated may run faster than the wall's."""


class FramePublisher:
    """Publishes frames and the state."""

    def __init__(self, node: Any, measured: bool, error: bool, clock: bool, velocities: bool) -> None:
        """`measured`, `error` and `clock` say what is published beside the simulated joint states and the state.

        Where `velocities` are wished, joint states have those that the driver would estimate, in the motion's own time.
        """
        self._logger = node.get_logger()
        self._simulated = JointStatePublisher(node, "simulated/joint_states", JOINTS)
        self._measured = JointStatePublisher(node, "measured/joint_states", JOINTS) if measured else None
        self._error = JointStatePublisher(node, "simulated/error", JOINTS[1:]) if error else None
        self._topics = [topic for topic in (self._simulated, self._measured, self._error) if topic]
        self._clock = node.create_publisher(Clock, "/clock", 10) if clock else None
        self._state = node.create_publisher(String, "~/state", latched())
        self._said = ""
        self._has_velocities, self._observers = velocities, dict[JointStatePublisher, Observer]()

    def take_model(self, model: FittedModel) -> None:
        """Estimate velocities by another model from now on, where they are wished."""
        if self._has_velocities:
            self._observers = {topic: Observer(model) for topic in (self._simulated, self._measured) if topic}

    @property
    def has_listeners(self) -> bool:
        """Whether there is somebody who hears every topic of joint states."""
        return all(topic.has_listeners for topic in self._topics)

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """Publish a frame."""
        if self._clock:
            self._clock.publish(Clock(clock=Time(nanoseconds=stamp_ns).to_msg()))
        if self._measured and frame.measured:
            self._publish(self._measured, frame.measured, frame, stamp_ns)
        self._publish(self._simulated, frame.simulated, frame, stamp_ns)
        if self._error and frame.error:
            self._error.publish(frame.error, stamp_ns)

    def _publish(self, topic: JointStatePublisher, positions: Triple, frame: Frame, stamp_ns: int) -> None:
        observer = self._observers.get(topic)
        velocities = observer.update(round(frame.time * 1e9), positions) if observer else ()
        topic.publish(positions, stamp_ns, velocities)

    def say(self, state: str) -> None:
        """Publish and log the state where it has become another."""
        if state != self._said:
            self._said = state
            self._state.publish(String(data=state))
            self._logger.info(state)

    def close(self) -> None:
        """Wait until everything has arrived."""
        for topic in self._topics:
            topic.finish()


class Playing:
    """Plays the motion of whatever model it is given."""

    def __init__(
        self,
        clock: Any,
        frames: FramePublisher,
        pace: Pace,
        once: bool,
        make_scene: Callable[[FittedModel], Scene],
        end: Callable[[int], None],
    ) -> None:
        """Play nothing yet; `once` says whether the node ends with it, by calling `end` with its exit code.

        `make_scene` is called for the first model, and again where the motion is to begin with another scene.
        """
        self._clock, self._frames, self._pace, self._make_scene, self._end = clock, frames, pace, make_scene, end
        self._once = once
        self._timer = RateTimer(pace.frequency)
        self._epoch_ns = time.time_ns()
        """What /clock says when the present player begins [ns]."""
        self._model: FittedModel | None = None
        self._player: Player | None = None
        self._awaiting: float | None = None
        """Since when listeners are waited for [s]."""
        self._problem = ""
        self._clockless = False
        """Whether time stands still, as none came from /clock yet."""
        self._paused = False
        self._closing = False
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._thread = threading.Thread(target=self._run, name="playing", daemon=True)

    @property
    def state(self) -> str:
        """In words, what it does."""
        if self._problem:
            return f"stopped: {self._problem}"
        player = self._player
        if player is None:
            return "waiting for parameters"
        if player.finished:
            return "finished"
        if self._clockless:
            return "waiting for a clock: use_sim_time is true, and nothing comes on /clock"
        return "paused" if self._paused else "playing"

    def take_model(self, model: FittedModel) -> None:
        """Show another model."""
        self._model = model
        self._change(lambda player: player.take_model(model))

    def take_pace(self, changed: Mapping[str, Any]) -> None:
        """Go on with other values of what is changeable in `Pace`, by name."""
        self._pace = replace(self._pace, **changed)
        self._change(lambda player: player.take_pace(self._pace))

    def begin_anew(self) -> None:
        """Play another scene from its beginning."""
        with self._lock:
            self._drop_player()
        self._change()

    def reset(self) -> None:
        """Go to the beginning."""
        self._change(lambda player: player.restart())

    def pause(self) -> None:
        """Stop where it is."""
        self._paused = True
        self._change()

    def resume(self) -> None:
        """Go on from where it is."""
        self._paused = False
        self._change(lambda player: self._timer.begin_anew())

    def start(self) -> None:
        """Play as soon as there is a model."""
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._closing = True
        self._wake.set()
        self._thread.join(5.0)

    def _change(self, what: Callable[[Player], None] = lambda _: None) -> None:
        """Change the player; where there is none yet, or none any more, make it of the present model and settings."""
        with self._lock:
            if self._model is not None:
                try:
                    if self._player is None:
                        self._player = Player(self._make_scene(self._model), self._pace)
                    else:
                        what(self._player)
                    self._problem = ""
                except CdpIdentError as error:
                    if self._once:
                        raise
                    self._stop(error)
            self._frames.say(self.state)
        self._wake.set()

    def _stop(self, error: CdpIdentError) -> None:
        self._problem = str(error)
        self._drop_player()

    def _drop_player(self) -> None:
        if self._player is not None:
            self._epoch_ns += round(self._player.played * 1e9)
            self._player = None

    def _run(self) -> None:
        try:
            while not self._closing:
                with self._lock:
                    seconds = self._play()
                if seconds > 0:
                    self._wake.wait(seconds)
                    self._wake.clear()
        finally:
            if not self._closing:
                self._end(1)

    def _is_awaited(self, player: Player) -> bool:
        if not self._once or player.played > 0 or self._frames.has_listeners:
            return True
        self._awaiting = self._awaiting or time.monotonic()
        return time.monotonic() - self._awaiting > _LISTENERS_WITHIN

    def _play(self) -> float:
        """Show the next frame if it is due; return how long it is until there is something to do [s]."""
        player = self._player
        if player is None or self._paused or player.finished or not self._is_awaited(player):
            return _IDLE
        now_ns = time.monotonic_ns() if self._pace.clock else self._clock.now().nanoseconds
        if self._clockless != (now_ns == 0):  # with use_sim_time, before the first /clock
            self._clockless = now_ns == 0
            self._frames.say(self.state)
        if self._clockless:
            return _IDLE
        due_ns = self._timer.next_ns(now_ns)
        if now_ns < due_ns:
            return min((due_ns - now_ns) * 1e-9, _LONGEST_SLEEP)
        stamp_ns = self._epoch_ns + round(player.played * 1e9) if self._pace.clock else due_ns
        try:
            frame = player.next()
        except CdpIdentError as error:
            self._stop(error)
            frame = None
        if frame is None:
            self._frames.say(self.state)
            if self._once:
                self._end(EXIT_BAD_INPUT if self._problem else 0)
            return _IDLE
        self._frames.show(frame, stamp_ns)
        self._timer.advance()
        return 0.0


class Shadowing:
    """Follows the rig with whatever model it is given."""

    def __init__(
        self, node: Any, frames: FramePublisher, options: TrialOptions, limits: TrialLimits, lead: float
    ) -> None:
        """The arguments but `node` and `frames` are those of `Shadow`."""
        self._frames, self._options, self._limits, self._lead = frames, options, limits, lead
        self._shadow: Shadow | None = None
        self._paused = False
        joints = JointNames(options.cart_joint, options.inner_joint, options.outer_joint)
        self._reader = PositionReader(joints, options.input == "joints")
        self._subscription = Subscription(node, JointState, options.topic, self._take)

    @property
    def state(self) -> str:
        """In words, what it does."""
        if self._shadow is None:
            return "waiting for parameters"
        return "paused" if self._paused else f"{self._shadow.phase.value}: {self._shadow.why}"

    def take_model(self, model: FittedModel) -> None:
        """Show another model."""
        if self._shadow is None:
            self._shadow = Shadow(model, self._options, self._limits, self._lead)
        else:
            with suppress(CdpIdentError):  # the state tells it
                self._shadow.take_model(model)
        self._frames.say(self.state)

    def reset(self) -> None:
        """Wait for the next release."""
        if self._shadow is not None:
            self._shadow.reset()

    def pause(self) -> None:
        """Show nothing; the rig is followed all the same."""
        self._paused = True

    def resume(self) -> None:
        """Show again."""
        self._paused = False

    def start(self) -> None:
        """The rig's next position starts it."""

    def close(self) -> None:
        """Nothing is to be ended."""

    def _take(self, raw: bytes) -> None:
        position = self._reader.read(raw)
        if position is None or self._shadow is None:
            return
        with suppress(CdpIdentError):  # the state tells it
            for stamp_ns, frame in self._shadow.take(position):
                if not self._paused:
                    self._frames.show(frame, stamp_ns)
        self._frames.say(self.state)
