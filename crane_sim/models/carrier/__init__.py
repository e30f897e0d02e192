"""What carries a load, a support and a winch: layout of a crane's state, exchanges of its load."""
