"""Compiled arithmetic: kernels and their cache, states, arrays, lanes, linear systems; numba only here."""
