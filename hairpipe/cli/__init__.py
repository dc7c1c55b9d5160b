"""The command line: one command a file, no logic. `main` is what the script `hairpipe` calls."""

from hairpipe.cli.entry import main

__all__ = ["main"]
