"""Assistance for an operator: zero-vibration (ZV) shaping of velocity commands, swing feedback.

Commands are shaped during operation.

The feedback is that of the law `anti_swing`: the speed k φ, φ the angle by which the payload is
ahead of the plumb line in the direction in which the joint moves its suspension point. It gives the
swing the characteristic polynomial s² + 2 z w s + w², for which the shaper is designed. Frequency w
and gain k = 2 z w l follow the rope's length l.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import sqrt

import numpy as np

from crane_control.anti_swing import gravity, swing_geometry
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive_instant
from crane_sim.trajectories.shaping import impulses

DAMPING = 0.1
"""Damping ratio z that the feedback gives the swing."""
_UPDATE_PERIOD = 0.5  # s between two updates of shaper and gains for the present configuration
# s of commands that are kept: half a period of a rope of 3.5 km, and no shaper's delay is longer
_HORIZON = 60.0
_TIME_TOLERANCE = 1e-6  # s, of instants that differ by rounding


class Assistance:
    """A shaper of velocity commands with feedback of the swing, which damps it.

    Attributes:
        delay: s, of the shaper's last impulse.
    """

    def __init__(self, scene: Scene) -> None:
        """Initialise at the scene's initial configuration.

        Raises:
            SceneError: nothing swings below an actuated joint.
        """
        self._scene, self._gravity = scene, gravity(scene)
        # (s from which it is held, operator's speeds)
        self._past: deque[tuple[float, tuple[float, ...]]] = deque()
        self._newest, self._next_update, self.delay = 0.0, 0.0, 0.0
        self._update_gains(0.0, scene.initial_q)
        if not np.any(self._feedback):
            raise SceneError(
                "assistance: no actuated joint moves a point below which the load swings"
            )

    def record_command(self, t: float, speeds: Sequence[float]) -> None:
        """Record the operator's speeds (nu,), held from t [s] on.

        It is to be called while assistance is off, too.
        """
        if t < self._newest:  # the plant was reset
            self.forget_commands()
            self._next_update = 0.0
        self._newest = t
        if not self._past or self._past[-1][1] != tuple(speeds):
            self._past.append((t, tuple(speeds)))
        while len(self._past) > 1 and self._past[1][0] <= t - _HORIZON:
            self._past.popleft()

    def forget_commands(self) -> None:
        """Forget the recorded commands: after a stop nothing of them may move the crane."""
        self._past.clear()

    def compute_velocity_command(self, t: float, q: Sequence[float]) -> tuple[float, ...]:
        """Return the velocity command (nu,) at q (nq,), from the commands recorded up to t [s]."""
        if t >= self._next_update:
            self._next_update = t + _UPDATE_PERIOD
            self._update_gains(t, q)
        shaped = sum(
            weight * np.array(self._at(t - delay))
            for weight, delay in zip(self._weights, self._delays, strict=True)
        )
        return tuple((shaped + self._feedback @ self._offset(t, q)).tolist())

    def _offset(self, t: float, q: Sequence[float]) -> np.ndarray:
        """Return the horizontal offset (2,) [m] of the payload from its suspension point."""
        derived = derive_instant(self._scene, t, q, (0.0,) * len(q))
        return (derived.payload - derived.tip)[0, :2]

    def _at(self, t: float) -> tuple[float, ...]:
        """Return the operator's command (nu,) that is held at t [s]; zero before the first."""
        for begin, speeds in reversed(self._past):
            if begin <= t + _TIME_TOLERANCE:
                return speeds
        return (0.0,) * len(self._scene.actuated)

    def _update_gains(self, t: float, q: Sequence[float]) -> None:
        """Update shaper and feedback gains for the posture at t [s], joint positions q (nq,)."""
        length, ahead, _ = swing_geometry(replace(self._scene, initial_q=tuple(q)), t)
        frequency = sqrt(self._gravity / length)
        self._weights, self._delays = impulses("zv", frequency, DAMPING)
        self.delay = self._delays[-1]
        self._feedback = 2.0 * DAMPING * frequency * ahead  # k φ = 2 z w l · offset / l
