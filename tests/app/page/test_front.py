"""The picture of the page on the front page: the demo with its first frames, which `make pictures` computes before."""

import os
from pathlib import Path

import pytest

from hairpipe.app.api.shot import load
from hairpipe.app.page.session import Session

from .live_page import Page, pictured, served, write_picture

GRAPHS = Path(__file__).parents[3] / "graphs"
FRAME, STRANDS = 1004, 3000


@pytest.mark.skipif("PAGE_PICTURES" not in os.environ, reason="computes the demo: make pictures")
def test_the_page_of_the_demo_shows_its_hair(opened, chromium):
    session = Session(load(GRAPHS / "demo.toml", cache=os.environ.get("PAGE_CACHE")))
    with pictured(chromium), served(session) as address:
        page = Page(opened(address), session)
        page.driver.execute_script("selectNode('hair'); app.set({ frame: arguments[0] })", FRAME)
        drawn = "return viewer?.items.at(-1)?.lengths?.length"
        page.until(lambda: page.driver.execute_script(drawn) == STRANDS)
        page.driver.execute_script("showAll(); viewer.camera.distance *= 0.8; viewer.redraw()")
        assert not page.driver.find_elements("id", "stale")
        assert not page.has_errors
        write_picture(page.driver, GRAPHS / "assets/pictures/page.webp")
