"""Metrics of simulated hair, as tables."""
