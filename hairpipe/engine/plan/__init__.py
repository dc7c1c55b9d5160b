"""Plans of runs with reasons, and removal of results from the store."""
