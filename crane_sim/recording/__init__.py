"""Recordings of runs for the Rerun viewer; Rerun is imported in `rerun` only."""
