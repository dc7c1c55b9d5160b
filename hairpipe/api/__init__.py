"""Python interface to load, plan, run and read graphs, for notebooks, `hairpipe.cli` and `hairpipe.tune`."""
