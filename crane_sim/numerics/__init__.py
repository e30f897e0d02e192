"""Arithmetic of compiled functions: states, arrays, rows, lanes, linear systems; and what is said of such functions."""
