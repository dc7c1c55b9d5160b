"""Contact: search, swept collisions, active sets and couplings; the laws are in hairpipe/laws."""
