"""Measurements of the simulator and of laws: reproduce, bench, league, soak, documentation."""
