"""Overhead cranes: a trolley (and a bridge) on rails, a hoist, and a cable of links with lumped masses.

Equations: Brogliato, "Lagrange dynamics of lumped-mass multibody models of overhead cranes", written in link tensions.
"""
