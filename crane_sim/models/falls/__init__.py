"""Cranes whose load hangs on several elastic falls, fastened apart: spreaders, lifting beams.

A fall is the rope between an upper and a lower point, of one or more parts. It only pulls: whether
it is taut is a mode, found by events. Nothing is solved for, since an elastic rope's tension is a
function of the state.
"""
