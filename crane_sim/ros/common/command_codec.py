"""Commands in joint states: as in ros2_control, each drive is commanded by a field of its own.

Each joint's number is in the field that its drive is commanded by.

A crane whose drives all take the same kind has commands with that field alone; where they differ, a
message has all fields that a drive takes, with NaN where a joint's drive takes another one.
"""

from collections.abc import Sequence
from math import nan

from crane_sim.ros.common.serialization import STATE, DecodedJointState, JointStateCodec
from crane_sim.scenes.scene import Scene


class CommandCodec:
    """Encoder and decoder of the commands of a scene's actuated joints.

    Attributes:
        kind: what all drives are commanded, `effort`, `velocity` or `position`; empty where they
            differ.
        decode: that of `JointStateCodec`.
    """

    def __init__(self, scene: Scene) -> None:
        """Lay the message out for the scene's actuated joints."""
        kinds = scene.commands
        self._kinds = dict(zip(scene.actuated, kinds, strict=True))
        self._fields = tuple(field for field in STATE if field in kinds) or ("effort",)
        self.kind = self._fields[0] if len(self._fields) == 1 else ""
        self._codec = JointStateCodec(scene.actuated, self._fields)
        self.decode = self._codec.decode

    def encode(self, stamp: int, command: Sequence[float]) -> bytes:
        """Return the message of a command (nu,) with `stamp`, ns."""
        if self.kind:
            return self._codec.encode(stamp, command)
        named = list(zip(self._kinds.values(), command, strict=True))
        vectors = [
            [value if kind == field else nan for kind, value in named] for field in self._fields
        ]
        return self._codec.encode(stamp, *vectors)

    def values(self, decoded: DecodedJointState) -> Sequence[float]:
        """Return the commands in a message by their names; fewer where fields are not filled."""
        if self.kind:
            return getattr(decoded, self.kind)
        columns = [
            getattr(decoded, self._kinds.get(name, self._fields[0])) for name in decoded.names
        ]
        return [column[i] for i, column in enumerate(columns) if i < len(column)]
