"""A live page in a real browser, driven as a person does."""

import io
import threading
import time
import tomllib
from contextlib import contextmanager

import numpy as np
from PIL import Image

from hairpipe.app.page.server import Server

WIDTH, HEIGHT = 1280, 800
"""Size of the window of pictures of pages [pixels]."""
SOCKET = '.socket[data-owner="{}"][data-side="{}"]'


@contextmanager
def served(session):
    """Serve the page of a session; yields its address."""
    server = Server(session, 0)
    thread = threading.Thread(target=server.serve)
    thread.start()
    try:
        yield server.address
    finally:
        server.stop()
        thread.join(20)


def do(driver, script, *given):
    """Run a script, and wait until what it began is drawn."""
    found = driver.execute_script(script, *given)
    drawn = """const [done] = arguments, look = (before) => app.showing.then(() => app.showing === before
            ? requestAnimationFrame(() => setTimeout(done, 60)) : look(app.showing));
        look(app.showing);"""
    driver.execute_async_script(drawn)
    return found


@contextmanager
def pictured(chromium):
    """Give the window the size and the theme of pictures of pages."""
    size = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    theme = {"features": [{"name": "prefers-color-scheme", "value": "light"}]}
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", theme)
    yield
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def write_picture(driver, path):
    """Write the page as a picture."""
    driver.execute_async_script("setTimeout(arguments[0], 700)")
    image = Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB")
    image.save(path, quality=80, method=6)


def pixels(driver, selector="#view"):
    """The picture of an element, (height, width, 3)."""
    element = driver.find_element("css selector", selector)
    return np.asarray(Image.open(io.BytesIO(element.screenshot_as_png)).convert("RGB")).astype(int)


class Page:
    """A live page, driven as a person does."""

    def __init__(self, driver, session):
        from selenium.webdriver import ActionChains
        from selenium.webdriver.common.keys import Keys

        self.driver, self.session, self.Keys = driver, session, Keys
        self.actions = lambda: ActionChains(driver, duration=30)

    @property
    def text(self):
        return self.session._history.text

    @property
    def tables(self):
        return tomllib.loads(self.text)

    def ask(self, expression, *given):
        """Value of an expression of the page."""
        return self.driver.execute_script(f"return {expression}", *given)

    @property
    def has_errors(self):
        return self.ask("document.body.dataset.errors") != "0"

    def find(self, selector):
        return self.driver.find_element("css selector", selector)

    def all(self, selector):
        return self.driver.find_elements("css selector", selector)

    def node(self, name):
        return self.find(f'.node[data-node="{name}"] .box')

    def until(self, true, most=20.0):
        end = time.monotonic() + most
        while not true():
            assert time.monotonic() < end, (self.ask("document.body.dataset.refused"), self.text)
            time.sleep(0.03)
        self.settle()

    def settle(self):
        """Wait until the page has drawn the present graph."""
        script = """const [revision, done] = arguments, there = () => app.graph.revision >= revision;
            const look = () => there() ? requestAnimationFrame(() => done(true)) : setTimeout(look, 20);
            look();"""
        with self.session._lock:  # a change announces its number last
            drawn = self.session.drawn
        self.driver.execute_async_script(script, drawn)

    def undo_all(self):
        """Undo all edits, choose nothing, and show the graph as it is shown at first, for another test."""
        if self.session._history.at:
            self.session.undo(-self.session._history.at)
        self.settle()
        first = "openTables.clear(); app.chosen = new Set(); app.fresh = true; app.set({ node: '' }); drawGraph()"
        do(self.driver, first)

    def press(self, keys, *modifiers):
        actions = self.actions()
        for modifier in modifiers:
            actions.key_down(modifier)
        actions.send_keys(keys)
        for modifier in modifiers:
            actions.key_up(modifier)
        actions.perform()

    def drag(self, begin, end=None, by=(0, 0)):
        """Drag from an element to another one, or by pixels."""
        actions = self.actions().move_to_element(begin).click_and_hold().move_by_offset(6, 6)
        (actions.move_to_element(end) if end else actions.move_by_offset(by[0] - 6, by[1] - 6)).release().perform()

    def choose(self, text):
        """Type in the small window that opens."""
        self.until(lambda: self.driver.find_elements("css selector", "#popup li, #popup input[placeholder^=name]"))
        self.actions().send_keys(text + self.Keys.ENTER).perform()
