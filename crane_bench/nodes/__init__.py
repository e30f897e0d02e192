"""Nodes of the laboratory, parts of no run: a bare echo, and an independent subscriber."""
