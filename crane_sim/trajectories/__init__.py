"""Functions of time: inputs, motions of bases and axes, waves, paths and what shapes them."""
