"""Functions of time: inputs, motions of bases and axes, waves, trajectories and input shapers."""
