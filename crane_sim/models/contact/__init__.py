"""Contact of a load with the ground or a deck: a body's points on a plane, rigid or compliant.

What touches is a mode of each point, found by events. Nothing here knows what the load hangs on:
contact adds forces to a body whose other accelerations are given, which holds where these are
functions of the state, as on elastic falls.
"""
