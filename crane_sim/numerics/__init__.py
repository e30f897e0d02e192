"""Arithmetic of compiled functions: states, arrays, rows, lanes, linear systems; and the folder of compiled code."""
