"""Sine and cosine of an angle, and products and sums rounded once: the same bits compiled, in Python, on any processor.

What processors call a fused multiply-add is asked for by name, and not left to the compiler; a processor without the
instruction only takes longer.
"""

from crane_sim.tracing.elementary import sincos as sincos
from crane_sim.tracing.operations import fma as fma
