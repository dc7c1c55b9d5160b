"""What the viewport of the page takes to draw hair again: time, bytes that are uploaded, draw calls."""

import html
import json
import re
import subprocess
import tempfile
from importlib.resources import files
from pathlib import Path

from hairpipe.bench.browser import FLAGS, browser_path
from hairpipe.bench.report import Report, make_report
from hairpipe.errors import BadInput

SCRIPTS = ("core.js", "app.js", "camera.js", "light.js", "channels.js", "shaders.js", "scene.js", "rays.js")
WEB = files("hairpipe.page") / "web"
PATIENCE = 200.0
"""Time after which a browser counts as hanging [s]."""
PAGE = """<!doctype html><meta charset="utf-8"><canvas width="1280" height="720"></canvas><body>
<script>const strands = {}, points = {}, redraws = {};</script>{}"""
SCENE = Path(__file__).with_name("redraw.js")


def measure_redraw(strands: int, points: int, redraws: int) -> Report:
    """Measure redraws of strands from turning eyes, 1280 x 720 pixels, in a browser without a graphics card.

    BadInput where there is no browser, or it has no WebGL2.
    """
    browser = browser_path()
    if browser is None:
        raise BadInput("no browser is installed", right="chromium on the path")
    texts = [*((WEB / name).read_text(encoding="utf-8") for name in SCRIPTS), SCENE.read_text(encoding="utf-8")]
    scripts = "".join(f"<script>{text}</script>" for text in texts)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder, "redraw.html")
        page.write_text(PAGE.format(strands, points, redraws, scripts), encoding="utf-8")
        command = [browser, *FLAGS.split(), f"--user-data-dir={folder}/profile", "--dump-dom", page.as_uri()]
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)
    found = re.search(r'data-found="([^"]*)"', done.stdout)
    if found is None:
        raise BadInput("the browser has drawn nothing", where=browser, right="a browser with WebGL2")
    return make_report(__name__, {"redraw": [json.loads(html.unescape(found[1]))]})
