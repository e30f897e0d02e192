"""The command of a compiled law, for calls from Python."""

from crane_sim import system
from crane_sim.numerics.jit import entry_point


@entry_point
def compute_efforts(law, t, q, v):
    """Return the efforts (nu,) [N m or N] of a law at time t [s], positions q (nq,) and velocities v (nq,)."""
    return system.command(law, t, q, v)
