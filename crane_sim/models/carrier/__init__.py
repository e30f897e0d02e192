"""What carries a load: a support and a winch; where things stand in the state of a crane, and exchanges of its load."""
