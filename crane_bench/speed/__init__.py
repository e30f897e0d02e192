"""Measurements of the simulator's speed, each beside what it is measured against."""
