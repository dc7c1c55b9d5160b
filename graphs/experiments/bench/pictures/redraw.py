"""What the viewport of the page takes to draw hair again: time, bytes that are uploaded, draw calls."""

import json
import tempfile
from importlib.resources import files
from pathlib import Path

import numpy as np

from hairpipe.app.page.values import script, strands_document
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.pictures.browser import browser_path, open_browser
from hairpipe.graphs.experiments.bench.report import Report, make_report
from hairpipe.values import Strands

SCRIPTS = ("core.js", "app.js", "camera.js", "light.js", "channels.js", "shaders.js", "scene.js", "rays.js")
WEB = files("hairpipe.app.page") / "web"
PAGE = """<!doctype html><meta charset="utf-8"><canvas width="1280" height="720"></canvas><body>
<script>const redraws = {};</script>{}"""
SCENE = Path(__file__).with_name("redraw.js")


def measure_redraw(strands: int, points: int, redraws: int) -> Report:
    """Measure redraws of strands from turning eyes, 1280 x 720 pixels, in a browser without a graphics card.

    BadInput where there is no browser, or it has no WebGL2.
    """
    browser = browser_path()
    if browser is None:
        raise BadInput("no browser is installed", right="chromium on the path")
    document = script("hair", *strands_document(make_hair(strands, points), strands))
    texts = [
        *((WEB / name).read_text(encoding="utf-8") for name in SCRIPTS),
        document,
        SCENE.read_text(encoding="utf-8"),
    ]
    scripts = "".join(f"<script>{text}</script>" for text in texts)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder, "redraw.html")
        page.write_text(PAGE.format(redraws, scripts), encoding="utf-8")
        with open_browser(browser, page.as_uri()) as opened:
            found = json.loads(opened.evaluate("document.body.dataset.found"))
    return make_report(__name__, {"redraw": [found]})


def make_hair(strands: int, points: int) -> Strands:
    """Return strands on a head, curved, with noise of 20 um, so that they compress no better than hair."""
    share = np.arange(points) / points
    height = 1.0 - 1.4 * (np.arange(strands) + 0.5) / strands
    turn = 2.399963 * np.arange(strands)[:, None] + 0.3 * share
    out = (0.1 + 0.15 * share) * np.sqrt(1.0 - height**2)[:, None]
    down = (0.1 + 0.15 * share) * height[:, None] - 0.12 * share**2
    smooth = np.stack([out * np.cos(turn), down, out * np.sin(turn)], axis=-1).reshape(-1, 3)
    rough = smooth + np.random.default_rng(0).normal(scale=20e-6, size=smooth.shape)
    offsets = np.arange(strands + 1, dtype=np.int64) * points
    return Strands(points=rough, offsets=offsets, velocities=np.zeros_like(rough), diameter=7e-5)
