"""An energy meter: a state that integrates the external work where samples are not exact."""

from typing import NamedTuple


class Meter(NamedTuple):
    """Marks a crane whose state has the integral of the external power [J].

    It is the power of drives, base, wind and losses.
    """


def meter_size(meter):
    """Return the number of floats that the meter adds to the state."""
    return 0 if meter is None else 1


def meter_entry(meter, value):
    """Return the value of the meter, or its rate, as a tuple, empty where there is none."""
    return () if meter is None else (value,)
