"""Rules for what changes over time."""
