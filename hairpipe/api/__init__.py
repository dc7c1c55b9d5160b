"""The Python interface: what notebooks, `hairpipe.cli` and `hairpipe.tune` load, plan, run and read graphs with."""
