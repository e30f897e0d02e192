"""Cranes with one rope: any support, rope and load put together."""
