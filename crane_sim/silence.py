"""What a plant in real time does while nobody commands."""

WAYS = {"zero": "zero effort", "hold": "the last effort holds", "brake": "the brakes act"}
"""The ways to choose from, and what is told of each."""
