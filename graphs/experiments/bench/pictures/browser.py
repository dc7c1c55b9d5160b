"""A browser without a window, driven through a pipe by Chrome's protocol for tools."""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from typing import Any

from hairpipe.errors import BadInput

FLAGS = """--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --window-size=1400,1300
    --no-first-run --disable-background-networking --disable-component-update --disable-sync --disable-quic"""
PATIENCE = 60.0
"""Time after which a page counts as not opening [s]."""


def browser_path() -> str | None:
    """Path of the installed browser; None without one."""
    return shutil.which("chromium")


class Browser:
    """A page that is open in a browser.

    Its pipe carries messages of JSON, each with a zero byte after it.
    """

    def __init__(self, commands: int, answers: int) -> None:
        self._commands, self._answers = commands, answers
        self._numbers = count(1)
        self._held = b""
        self._page: dict[str, str] = {}

    def attach(self, address: str) -> None:
        """Wait for a page to be ready; BadInput where it is not."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            pages = [one for one in self.ask("Target.getTargets")["targetInfos"] if one["url"].startswith(address)]
            if pages and not self._page:
                found = self.ask("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)
                self._page = {"sessionId": found["sessionId"]}
            if self._page and self.evaluate("document.body?.dataset.state") == "ready":
                return
            time.sleep(0.05)
        raise BadInput("did not become ready", where="the page", right="a browser that can open it")

    def evaluate(self, script: str) -> Any:
        """Return the value of an expression in the page, after its promise; BadInput where it throws."""
        found = self.ask("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in found:
            what = str(found["exceptionDetails"]["exception"].get("description"))
            raise BadInput(what.partition("\n")[0], where="the page")  # without the stack
        return found["result"].get("value")

    def ask(self, method: str, **given: Any) -> dict[str, Any]:
        """Send a command, and return its result; BadInput where the browser refuses it or has ended."""
        number = next(self._numbers)
        os.write(
            self._commands, json.dumps({"id": number, "method": method, "params": given, **self._page}).encode() + b"\0"
        )
        while True:
            while b"\0" not in self._held:
                part = os.read(self._answers, 1 << 16)
                if not part:
                    raise BadInput("has ended", where="the browser")
                self._held += part
            text, _, self._held = self._held.partition(b"\0")
            answer = json.loads(text)
            if answer.get("id") == number:
                if "error" in answer:
                    raise BadInput(answer["error"]["message"], where=method)
                return answer["result"]


@contextmanager
def open_browser(path: str, address: str) -> Iterator[Browser]:
    """Open a page, wait until it is ready, and end the browser; BadInput where it does not become ready."""
    (theirs, commands), (answers, ours) = os.pipe(), os.pipe()

    def place() -> None:  # by the protocol: commands at 3, answers at 4
        copies = os.dup(theirs), os.dup(ours)
        os.dup2(copies[0], 3)
        os.dup2(copies[1], 4)

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        words = [path, *FLAGS.split(), f"--user-data-dir={profile}", "--remote-debugging-pipe", address]
        process = subprocess.Popen(
            words, pass_fds=(3, 4), preexec_fn=place, stderr=subprocess.DEVNULL, start_new_session=True
        )
        for end in (theirs, ours):
            os.close(end)
        try:
            browser = Browser(commands, answers)
            browser.attach(address)
            yield browser
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            for end in (commands, answers):
                os.close(end)
