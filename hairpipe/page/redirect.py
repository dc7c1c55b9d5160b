"""Open the page in a browser without its secret address in a command line, which every local user may read."""

import html
import os
import webbrowser
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from hairpipe.graph.store.atomic import sweep, workspace
from hairpipe.graph.store.ownership import make_own, own_folder

REDIRECT = '<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0;url={}"><title>hairpipe</title>'


@contextmanager
def redirecting(address: str) -> Iterator[Path]:
    """Write a temporary file that redirects a browser to an address, readable by this user only.

    OSError without a writable folder of the user.
    """
    folder = own_folder("state") / "pages"
    make_own(folder)
    sweep(folder)
    with workspace(folder) as place:
        path = place / "page.html"
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(REDIRECT.format(html.escape(address)))
        yield path


@contextmanager
def opened(address: str) -> Iterator[None]:
    """Open an address in the user's browser while it is served, if the file can be written.

    The address is printed in any case.
    """
    with ExitStack() as stack:
        with suppress(OSError):
            webbrowser.open(stack.enter_context(redirecting(address)).as_uri())
        yield
