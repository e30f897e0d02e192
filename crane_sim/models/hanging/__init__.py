"""Functions of `crane_sim.system` that cranes share whose load hangs below any support: links, springs or falls."""
