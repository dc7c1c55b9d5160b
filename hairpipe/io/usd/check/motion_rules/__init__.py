"""Rules for values over time."""
