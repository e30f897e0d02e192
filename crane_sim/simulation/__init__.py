"""Scenes in motion: the plant, whole runs, batches, their metrics."""
