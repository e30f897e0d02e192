"""Recordings of runs for the Rerun viewer; nothing outside this package knows Rerun."""
