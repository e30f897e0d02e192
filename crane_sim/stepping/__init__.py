"""Compiled loops over control periods."""
