"""What a report costs who opens it: bytes on disk, and processor seconds until a browser has drawn it."""

import os
import signal
import subprocess
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.pictures.browser import FLAGS, browser_path
from hairpipe.graphs.experiments.bench.report import Case, Report, make_report

PATIENCE = 120.0
"""Time after which a page counts as not opening [s]."""
POLL = 0.02
READY = 'data-state="ready"'


def measure_page(folder: Path) -> Report:
    """Measure what a report takes until a browser without a graphics card has drawn it.

    BadInput where there is none, no browser, or the page does not become ready.
    """
    page = folder / "index.html"
    browser = browser_path()
    if not page.is_file():
        raise BadInput("holds no report", where=folder, right="a folder that `hairpipe report` has written")
    if browser is None:
        raise BadInput("no browser is installed", right="chromium on the path")
    sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
    opening = opening_seconds(browser, page)
    case: Case = {"files": len(sizes), "size [bytes]": sum(sizes), "opening [processor s]": opening}
    return make_report(__name__, {"page": [case]})


def opening_seconds(browser: str, page: Path) -> float:
    """Open a page, and return the processor seconds that all processes of the browser have taken when it is ready."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [browser, *FLAGS.split(), f"--user-data-dir={profile}", "--virtual-time-budget=60000", "--dump-dom"]
        process = subprocess.Popen(
            [*command, page.resolve().as_uri()],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        taken: dict[int, float] = {}
        begun = time.monotonic()
        try:
            while process.poll() is None and time.monotonic() - begun < PATIENCE:
                taken |= session_seconds(process.pid)
                time.sleep(POLL)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        dumped = process.communicate()[0].decode("utf-8", "replace")
    if READY not in dumped:
        raise BadInput("did not become ready", where=page, right="a whole report")
    return sum(taken.values())


def session_seconds(session: int) -> dict[int, float]:
    """Processor seconds of each process of a session, by its number."""
    found = {}
    tick = os.sysconf("SC_CLK_TCK")
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, IndexError, ValueError):
            fields = (place / "stat").read_text().rpartition(")")[2].split()
            if int(fields[3]) == session:
                found[int(place.name)] = (int(fields[11]) + int(fields[12])) / tick
    return found
