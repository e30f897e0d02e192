"""The summary in a recording: every number has its unit."""

from crane_sim.recording.metric_units import summary_table


def test_angles_have_their_unit() -> None:
    """Metrics in degrees say so, whatever they are called; others have theirs, and numbers without one stay bare."""
    table = summary_table(
        "run", {"peak_tilt_deg": 12.0, "peak_swing_deg": 1.5, "steps": 3, "peak_effort": {"slew": 2.0}}, "m"
    )
    for row in ("| peak tilt | 12 ° |", "| peak swing | 1.5 ° |", "| steps | 3 |", "peak effort [N m, N]"):
        assert row in table
