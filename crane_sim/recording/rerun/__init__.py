"""Rerun recordings of a run: the only modules that import Rerun."""
