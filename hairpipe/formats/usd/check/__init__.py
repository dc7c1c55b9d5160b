"""Strict lint of shots: validators of usd-core, and rules for hair, which usd-core does not have."""
