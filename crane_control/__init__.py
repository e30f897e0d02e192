"""Control laws for cranes and the node that runs them."""
