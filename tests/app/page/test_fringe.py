"""An empty project becomes a simulated fringe in the wind, as a person would do it: menus, wires and fields alone.

With PAGE_PICTURES=FOLDER it has more hair, and writes the pictures of the tutorial (`make pictures`).
"""

import os
import tomllib
from pathlib import Path

import numpy as np
import pytest

import hairpipe
from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.page.session import Session

from .live_page import SOCKET, Page, pictured, served, write_picture

pytestmark = [pytest.mark.slow, pytest.mark.kernels]
PICTURES = os.environ.get("PAGE_PICTURES")
STRANDS, SEGMENTS, LAST = ("800", "10", "8") if PICTURES else ("40", "8", "3")
DONE = "return app.base.verdict.missing === 0 && !app.base.verdict.running"
FRINGE = """schema = 1
frames = [1, {last}]
fps = 24

[bust]
type = "make_bust"

[groom]
type = "grow_groom"
in.scalp = "bust"
strands = {strands}
segments = {segments}
length = 0.11
lift = 15
comb.sideways = 0
comb.back = -1

[body]
type = "pose_body"
in.rest = "bust"

[levelset]
type = "bake_levelset"
in.body = "body"
voxel = 0.008

[hair]
type = "simulate_hair"
in.groom = "groom"
in.body = "body"
in.surface = "levelset"
wind = {{ velocity = [1, 0, -4] }}
"""


class Person(Page):
    """A live page with what a person does in this tutorial."""

    def add(self, name, at):
        """Add a node by Shift-A at a place of the graph, as shares of its pane."""
        self.actions().move_to_element_with_offset(self.find("#graph"), *self.offset(at)).perform()
        self.press("a", self.Keys.SHIFT)
        self.choose(name)
        self.arrived(name)

    def pull(self, owner, name, at):
        """Add a node at the end of a wire from the output of another one."""
        self.until(lambda: self.dragged_undisturbed(lambda: self.pull_wire(owner, at)))
        self.choose(name)
        self.arrived(name)

    def dragged_undisturbed(self, drag):
        """Drag; return whether the graph was not drawn again before the end, as after an edit or a run."""
        from selenium.common import StaleElementReferenceException

        try:
            drag()
        except StaleElementReferenceException:
            return False
        return True

    def pull_wire(self, owner, at):
        """Pull a wire to a place."""
        actions = self.actions().move_to_element(self.find(SOCKET.format(owner, "out"))).click_and_hold()
        actions.move_by_offset(6, 6).move_to_element_with_offset(self.find("#graph"), *self.offset(at)).release()
        actions.perform()

    def wire(self, owner, node, name):
        begin, end = SOCKET.format(owner, "out"), SOCKET.format(node, "in") + f'[data-name="{name}"]'
        self.until(lambda: self.dragged_undisturbed(lambda: self.drag(self.find(begin), self.find(end))))
        self.until(lambda: name in self.tables[node].get("in", {}))

    def arrived(self, name):
        self.until(lambda: name.rpartition("_")[2] in self.tables)

    def offset(self, at):
        frame = self.find("#graph").rect
        return [int((share - 0.5) * frame[side]) for share, side in zip(at, ("width", "height"), strict=True)]

    def write(self, setting, text, place=0):
        before = self.text
        field = self.driver.find_elements("css selector", f"{setting} input")[place]
        self.driver.execute_script("arguments[0].scrollIntoView({ block: 'center' })", field)
        field.click()
        field.send_keys(self.Keys.CONTROL, "a")
        field.send_keys(self.Keys.NULL, text, self.Keys.ENTER)
        self.until(lambda: self.text != before)

    def picture(self, name):
        """Write the page as a picture of the tutorial, if these are asked for."""
        if PICTURES:
            write_picture(self.driver, Path(PICTURES) / f"page_{name}.webp")


@pytest.fixture
def person(opened, chromium, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    session = Session(load_draft("fringe.toml", EMPTY, cache=os.environ.get("PAGE_CACHE", str(tmp_path / "cache"))))
    with pictured(chromium), served(session) as address:
        yield Person(opened(address), session)


def test_an_empty_project_becomes_a_fringe_in_the_wind(person):
    person.find(".shot summary").click()
    person.write('[data-shot="frames"]', LAST, place=1)
    person.add("make_bust", (0.12, 0.3))
    person.picture("first")
    person.pull("bust", "grow_groom", (0.45, 0.25))
    for setting, text in (("strands", STRANDS), ("segments", SEGMENTS), ("length", "0.11"), ("lift", "15")):
        person.write(f'[data-setting="{setting}"]', text)
    person.write('[data-setting="comb.sideways"]', "0")
    person.write('[data-setting="comb.back"]', "-1")
    person.find("#do-run").click()
    drawn = "return viewer?.items.at(-1)?.lengths?.length"
    person.until(lambda: person.driver.execute_script(drawn) == int(STRANDS), 60)
    person.until(lambda: person.driver.execute_script(DONE))
    person.picture("groom")
    person.pull("bust", "pose_body", (0.42, 0.75))
    person.pull("body", "bake_levelset", (0.62, 0.8))
    person.write('[data-setting="voxel"]', "0.008")
    person.pull("groom", "simulate_hair", (0.85, 0.4))
    person.wire("body", "hair", "body")
    person.wire("levelset", "hair", "surface")
    person.press(person.Keys.HOME)
    person.node("hair").click()
    person.find("details.absent summary").click()
    person.find('details.absent [data-group="wind"] input').click()
    person.until(lambda: "wind" in person.tables["hair"])
    person.write('[data-setting="wind.velocity"]', "1", place=0)
    person.write('[data-setting="wind.velocity"]', "-4", place=2)
    person.picture("wind")
    person.find("#do-run").click()
    person.until(lambda: person.driver.execute_script(DONE), 400)
    person.driver.execute_script("app.set({ frame: app.graph.frames[1] })")
    person.picture("fringe")
    person.press("s", person.Keys.CONTROL)
    person.until(lambda: Path("fringe.toml").exists())
    assert not person.has_errors
    written = Path("fringe.toml").read_text()
    assert written.partition("\n[layout]")[0] == FRINGE.format(last=LAST, strands=STRANDS, segments=SEGMENTS)
    assert set(tomllib.loads(written)["layout"]) == {"bust", "groom", "body", "levelset", "hair"}
    shot = hairpipe.load("fringe.toml", cache=person.session._shot.cache)
    tips = [strands.points[strands.offsets[1:] - 1] for strands in shot.get("hair", frames=[1, int(LAST)]).values()]
    blown = (tips[1] - tips[0]).mean(axis=0)
    assert blown @ np.array([1.0, 0.0, -4.0]) > 0 and blown[2] < -1e-4
