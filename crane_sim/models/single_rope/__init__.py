"""Cranes with one rope: any support, rope and payload put together."""
