"""Soaks, `crane soak`: what happens to runs that are killed, interrupted or kept going for long."""
