"""Brakes: friction that sticks by a spring and slips at its capacity, one on every actuated joint.

The effort of a brake is that of a spring to an anchor and a damper, both together at most its
capacity; where the spring alone would be stronger, the anchor slips along (elastoplastic friction).
It slips at the ends of periods only: within one the capacity acts on the joint as long as it is
exceeded. Such an effort is that of a potential, |effort| <= capacity, plus a damper, and moving the
anchor only lowers that potential: a brake never supplies more energy than its spring has stored.

Where an effort is no force the same element serves: it is an acceleration for a drive that imposes
accelerations; a winch with `drive: rate` gets zero; a drive by position gets the anchor's position
as its setpoint (`position_drive` is 1).
"""


def clip(value, bound):
    """Return the value clipped to -bound .. bound."""
    return min(max(value, -bound), bound)


def compute_brake_effort(drive):
    """Return the effort of a brake on its joint, whose position and velocity are in the record."""
    effort = drive.stiffness * (drive.anchor - drive.position) - drive.damping * drive.velocity
    return drive.position_drive * drive.anchor + clip(effort, drive.capacity)


def engage(drive, effort):
    """Anchor a brake so that its spring takes over the drive's effort, up to its capacity."""
    drive.anchor = drive.position
    if drive.stiffness > 0.0:
        drive.anchor += clip(effort, drive.capacity) / drive.stiffness


def read_limit_switch(drive):
    """Trip the drive of a joint beyond a limit switch; it stays tripped.

    The joint's position is in the record.
    """
    beyond = max(drive.position - drive.switch_high, drive.switch_low - drive.position)
    drive.tripped = drive.tripped or beyond > 0.0
    drive.overtravel = max(drive.overtravel, beyond)


def slip(drive):
    """Move the anchor of a brake where its spring is stretched beyond the capacity."""
    if drive.stiffness > 0.0:
        max_stretch = drive.capacity / drive.stiffness
        drive.anchor = drive.position + clip(drive.anchor - drive.position, max_stretch)
