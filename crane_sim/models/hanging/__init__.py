"""Functions of `crane_sim.system` shared by cranes whose load hangs on links, springs or falls."""
