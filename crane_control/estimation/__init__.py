"""Estimators that laws are made of."""
