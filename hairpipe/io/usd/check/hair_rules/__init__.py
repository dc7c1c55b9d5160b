"""Rules for hair at one time."""
