"""Benches of parts of hairpipe: what they cost on this machine, and what they withstand."""
