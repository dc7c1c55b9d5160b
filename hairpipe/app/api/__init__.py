"""Python interface to load, plan, run and read graphs, for notebooks, `hairpipe.app.cli` and `hairpipe.app.tune`."""
