"""The laboratory: what measures and proves the simulator, laws and documentation.

The product imports none of it.
"""
