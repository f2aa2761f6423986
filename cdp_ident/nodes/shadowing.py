# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A simulated motion beside a live rig on the simulator's node: every position of the rig brings one of the model."""

from contextlib import suppress
from typing import Any

from sensor_msgs.msg import JointState

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.errors import CdpIdentError
from cdp_ident.nodes.frame_publisher import FramePublisher
from cdp_ident.replay.shadow import Shadow
from cdp_ident.rig.recording.detector import TrialLimits
from cdp_ident.rig.recording.facts import JointNames, PositionReader
from cdp_ident.ros.qos import Subscription
from cdp_ident.trial.options import TrialOptions


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
        self._frames.say(self.state)

    def pause(self) -> None:
        """Show nothing; the rig is followed all the same."""
        self._paused = True
        self._frames.say(self.state)

    def resume(self) -> None:
        """Show again."""
        self._paused = False
        self._frames.say(self.state)

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
