"""Rules for the composition of a stage."""
