"""Soaks: runs that are killed, interrupted and kept going for long, and what that did to them; `crane soak`."""
