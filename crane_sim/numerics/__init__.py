"""Arithmetic of compiled functions: states, arrays, rows, lanes, linear systems; and decorators."""
