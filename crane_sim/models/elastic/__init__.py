"""Cranes whose cable is a chain of springs and dampers below any support, or a planar trolley."""
