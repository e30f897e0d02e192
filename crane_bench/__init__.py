"""The laboratory: what measures and proves the simulator, its laws and its documentation. The product imports none."""
