"""Waits for a file, so that a run lasts as long as a test needs it."""

import time
from pathlib import Path

from hairpipe.engine import Frames, node
from hairpipe.values import Strands, Table
from hairpipe.values.table import table_of_columns

PATIENCE = 120.0


@node(frames="once")
def stay(hair: Frames[Strands], *, until: str) -> Table:
    """The time until a file was there."""
    begun = time.monotonic()
    while not Path(until).exists() and time.monotonic() < begun + PATIENCE:
        time.sleep(0.02)
    return table_of_columns({"waited [s]": [time.monotonic() - begun]})
