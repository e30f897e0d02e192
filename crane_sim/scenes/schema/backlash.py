"""The group `backlash` of a scene file: play between drives and the joints of the support."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import Field

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.models.supports import backlash as drives_with_play
from crane_sim.models.supports.support import Support, own_count
from crane_sim.scenes.schema.groups import Group

MAX_DRIVES = 16


class Drive(Group):
    """A drive with its own inertia that moves a joint through play and an elastic shaft.

    All is reflected to the joint: of a motor behind the ratio n the inertia is n² times its own,
    the play that of motor shaft, gear and wheel together.
    """

    inertia: Positive  # effort's unit s²/joint's unit, of motor and gear: kg, or kg m² of a joint
    # that turns
    play: Positive  # joint's unit, from one flank to the other
    stiffness: Positive  # effort's unit/joint's unit, of shaft and gear in contact
    damping: NonNegative = 0.0  # effort's unit s/joint's unit, of the same
    share: Positive = 1.0  # -, of the joint's effort, in proportion to the shares of its other
    # drives
    offset: Real = 0.0  # joint's unit, of the drive from the middle of its play at t = 0; it moves
    # with the joint then


JointDrives = Annotated[tuple[Drive, ...], Field(min_length=1, max_length=MAX_DRIVES)]
Backlash = Mapping[str, Sequence[Drive]]


def check_joint_names(group: Any, names: Sequence[str]) -> Any:
    """Return a group of a file by joint as it is.

    Raises:
        ValueError: there is no joint of one of its keys.
    """
    for name in group if isinstance(group, Mapping) else ():
        if name not in names:
            raise ValueError(unknown_key(str(name), names, "joint"))
    return group


def drives_of(backlash: Backlash, joints: Sequence[Any]) -> list[tuple[int, str, Drive]]:
    """Return (index of the joint, name of the drive, drive) in the order of a support's joints."""
    return [
        (i, f"{joint.name}_drive_{k}", drive)
        for i, joint in enumerate(joints)
        for k, drive in enumerate(backlash.get(joint.name, ()), 1)
    ]


def drive_names(backlash: Backlash, joints: Sequence[Any]) -> tuple[str, ...]:
    """Return the names of the drives' positions, which are joints as well."""
    return tuple(name for _, name, _ in drives_of(backlash, joints))


def drive_units(backlash: Backlash, joints: Sequence[Any]) -> tuple[str, ...]:
    """Return the units of the drives' positions."""
    return tuple(joints[i].unit for i, _, _ in drives_of(backlash, joints))


def drives_at_start(backlash: Backlash, joints: Sequence[Any], q: Any, v: Any) -> tuple[Any, Any]:
    """Return (positions, velocities) of the drives at t = 0, when the joints have q and v."""
    drives = drives_of(backlash, joints)
    return tuple(q[i] + drive.offset for i, _, drive in drives), tuple(v[i] for i, _, _ in drives)


def shaft_frequency(backlash: Backlash) -> float:
    """Return a bound [rad/s] of the frequencies and decay rates of drives, 0 without any.

    ω² ≤ max(k / m) + Σ k / M of the shafts k and drives m of a joint with the inertia M; a joint
    counts as no lighter than its heaviest drive. Where the shafts' damping c is strong, motions
    decay at up to max(c / m) + Σ c / M.
    """
    rates = [0.0]
    for drives in backlash.values():
        rates += [_largest_ratio(drives, "stiffness") ** 0.5, _largest_ratio(drives, "damping")]
    return max(rates)


def _largest_ratio(drives: Sequence[Drive], key: str) -> float:
    """Return max(k / m) + Σ k / M of a joint's drives, k being the key of their shafts."""
    total = sum(getattr(drive, key) for drive in drives)
    own = max(getattr(drive, key) / drive.inertia for drive in drives)
    return own + total / max(drive.inertia for drive in drives)


def add_backlash(support: Support, backlash: Backlash, joints: Sequence[str]) -> Support:
    """Return the support with its drives that have play, as it is without any.

    Raises:
        SceneError: a drive starts in its joint's flank.
    """
    for name, drives in backlash.items():
        for k, drive in enumerate(drives):
            half = 0.5 * drive.play
            if abs(drive.offset) > half:
                key = f"backlash.{name}[{k}].offset = {drive.offset:g}"
                raise SceneError(f"{key}: must be within half of the play, {half:g}")
    if not any(backlash.values()):
        return support
    rows: list[tuple[drives_with_play.Drive, ...]] = [()] * own_count(support)
    for i, name in enumerate(joints):
        own = backlash.get(name, ())
        total = sum(drive.share for drive in own)
        rows[i] = tuple(
            drives_with_play.Drive(d.inertia, d.share / total, d.play, d.stiffness, d.damping)
            for d in own
        )
    return support._replace(drives=tuple(rows))
