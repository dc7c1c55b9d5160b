"""The page at sizes of windows and tablets: nothing is cut, nothing overlaps, all is read.

With PAGE_SHOTS=FOLDER pictures are written of each size, theme and preset, to be looked at.
"""

import itertools
import os
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest

from hairpipe.app.api.shot import load
from hairpipe.app.page.documents import graph_document

from .live_page import do, pixels

pytestmark = pytest.mark.slow
SHOTS = os.environ.get("PAGE_SHOTS")
PRESETS = ("edit", "look", "compare")
SIZES = [(1440, 900), (1280, 720), (1024, 768), (820, 1180)]
CUT = """return [...document.querySelectorAll("body *")].filter((one) => {
    if (!one.checkVisibility() || one.closest("svg, .facts, header > code")) return false;
    const { overflowX, overflowY } = getComputedStyle(one), hides = (flow) => flow === "hidden" || flow === "clip";
    const wide = one.scrollWidth > one.clientWidth + 1, high = one.scrollHeight > one.clientHeight + 1;
    const inline = one.matches("input") || hides(overflowX);
    return one.clientWidth && ((wide && inline) || (high && hides(overflowY)));
}).map((one) => `${one.tagName} ${one.id} ${one.className} ${one.textContent.slice(0, 40)}`);"""
"""Elements whose text does not fit and is not scrolled to; the facts and the command have titles with all of it."""
OUTSIDE = """const wide = document.documentElement.clientWidth;
return [...document.querySelectorAll("button, input, select, summary, dd")].filter((one) => one.checkVisibility())
    .filter((one) => { const at = one.getBoundingClientRect(); return at.left < -1 || at.right > wide + 1; })
    .map((one) => one.outerHTML.slice(0, 80));"""
STRIP = """const time = document.getElementById("time");
return { rows: stripNodes().length, scroll: time.scrollHeight, client: time.clientHeight,
    below: document.getElementById("strip").getBoundingClientRect().bottom - time.getBoundingClientRect().bottom };"""


@pytest.fixture
def live(looked, opened, watched):
    """The page, with the graph of the shot in it."""
    if looked.ask("app.graph.name") != "shot":
        opened(watched[1])
    return looked


@pytest.fixture
def sized(looked):
    """Give the window a size, and a theme."""
    send = looked.driver.execute_cdp_cmd

    def resize(width, height, theme="dark"):
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        send("Emulation.setDeviceMetricsOverride", size)
        theme = {"name": "prefers-color-scheme", "value": theme}
        send("Emulation.setEmulatedMedia", {"features": [theme]})

    yield resize
    send("Emulation.clearDeviceMetricsOverride", {})
    send("Emulation.setEmulatedMedia", {"features": []})
    looked.driver.execute_script("choosePreset('edit')")


def show_graph(driver, name):
    """Show a shipped graph in place of that of the page, without results."""
    shot = load(name)
    state = {node: {"cells": [{"frame": shot.graph.begin, "state": "cached"}]} for node in shot.nodes}
    script = """const [graph, nodes] = arguments, fields = { muted: false, fault: null };
        graph.nodes.forEach((node) => Object.assign(node, fields));
        resolveTypes(graph);
        Object.assign(graph, { edits: [], undo: null, redo: null, layout: {} });
        app.set({ node: "", frame: graph.frames[0], graph, state: { ...app.state, nodes } });
        app.fresh = true;
        drawGraph();"""
    do(driver, script, graph_document(shot), state)
    return [*shot.nodes]


def test_nothing_is_cut_at_any_size(live, sized):
    driver, themes = live.driver, ("light", "dark") if SHOTS else ("dark",)
    for size, theme, preset in itertools.product(SIZES, themes, PRESETS):
        sized(*size, theme)
        do(driver, "choosePreset(arguments[0]); selectNode('ball')", preset)
        before = live.find("#stage").rect
        do(driver, "selectNode('hair')")
        assert live.find("#stage").rect == before, "a pane moves when a node is selected"
        assert driver.execute_script(CUT) == [] and driver.execute_script(OUTSIDE) == [], (size, preset)
        if SHOTS:
            driver.save_screenshot(str(Path(SHOTS) / f"{size[0]}_{theme}_{preset}.png"))


def test_all_rows_of_the_demo_are_seen_in_every_preset(looked, sized):
    nodes = show_graph(looked.driver, "demo")
    for size, preset in itertools.product(SIZES, PRESETS):
        sized(*size)
        do(looked.driver, "choosePreset(arguments[0]); selectNode('hair')", preset)
        strip = looked.driver.execute_script(STRIP)
        assert strip["rows"] == (1 if preset == "look" else len(nodes))
        assert strip["scroll"] <= strip["client"] and strip["below"] <= 0, (size, preset, strip)


def test_the_row_of_the_selected_node_is_scrolled_to(looked, sized):
    sized(1280, 720)
    nodes = show_graph(looked.driver, "experiments/stability_models")
    place = """const at = (selector) => document.querySelector(selector).getBoundingClientRect();
        const row = stripNodes().findIndex((one) => one.name === app.node);
        const top = at("#strip canvas").top + STRIP.top + STRIP.row * row;
        return [top - at("#timeline").bottom, at("#time").bottom - top - STRIP.row];"""
    strip = looked.driver.execute_script(STRIP)
    assert strip["scroll"] > strip["client"] + 40, "more rows than are seen at once"
    for name in (nodes[-1], nodes[0], nodes[len(nodes) // 2]):
        do(looked.driver, "selectNode(arguments[0])", name)
        assert min(looked.driver.execute_script(place)) >= 0, name


def test_a_graph_is_first_shown_at_a_scale_at_which_it_is_read(looked, sized):
    sized(1024, 768)
    show_graph(looked.driver, "demo")
    scale = "return document.getElementById('graph').getScreenCTM().a"
    assert looked.driver.execute_script(scale) > 0.599
    do(looked.driver, "showAll()")
    assert looked.driver.execute_script(scale) < 0.599


def contrast(one, other):
    """Contrast of two colours after WCAG 2."""

    def luminance(colour):
        parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
        linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts]
        return sum(share * v for share, v in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    low, high = sorted(map(luminance, (one, other)))
    return (high + 0.05) / (low + 0.05)


def test_names_of_nodes_are_read_on_the_colour_of_every_state(looked):
    states = looked.ask("Object.values(STATES).map((colour) => [colour, inkOn(colour)])")
    assert len(states) > 8 and min(contrast(*pair) for pair in states) >= 4.5


def test_wires_and_sockets_are_seen_on_the_boxes_of_nodes(looked, sized):
    """WCAG 2.2 asks for a contrast of 3 of what is no text (success criterion 1.4.11)."""
    types = looked.ask("[...Object.values(COLOURS), typeColour('another')]")
    boxes = set()
    for theme in ("dark", "light"):
        sized(1280, 720, theme)
        boxes.add(looked.ask("themed('--box')"))
    assert len(boxes) == 2 and min(contrast(colour, box) for colour in types for box in boxes) >= 3.0


def test_no_texts_of_a_node_overlap_in_any_shipped_graph(looked):
    overlaps = """const meet = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width
            && a.y + 4 < b.y + b.height && b.y + 4 < a.y + a.height; // boxes of lines overlap, letters do not
        return [...document.querySelectorAll("#graph .node")].flatMap((node) => {
            const box = node.querySelector(".box").getBBox(), texts = [...node.querySelectorAll("text")];
            const places = texts.map((text) => text.getBBox());
            return texts.flatMap((text, k) => [
                ...(places[k].x + places[k].width > box.x + box.width ? [`${text.textContent} leaves its box`] : []),
                ...texts.filter((_, other) => other > k && meet(places[k], places[other]))
                    .map((other) => `${text.textContent} meets ${other.textContent}`)]);
        });"""
    for name in ("demo", "experiments/interpolation", "experiments/stick"):
        show_graph(looked.driver, name)
        assert looked.driver.execute_script(overlaps) == [], name


def test_cells_of_a_row_lie_next_to_each_other(live):
    do(live.driver, "selectNode('reach')")
    tops = """return [...document.querySelectorAll(".table > table tbody tr")]
        .map((row) => new Set([...row.cells].map((cell) => cell.offsetTop)).size);"""
    assert set(live.driver.execute_script(tops)) == {1}


def test_a_picture_fits_into_the_viewport(live, sized):
    sized(1280, 720)
    do(live.driver, "choosePreset('edit'); selectNode('picture')")
    script = """const [source, done] = arguments, image = document.querySelector('.book img');
        image.src = source;
        image.decode().then(() => requestAnimationFrame(() => done(image.naturalHeight)));"""
    assert live.driver.execute_async_script(script, HIGH) == 2000
    rows, columns = np.nonzero(pixels(live.driver, "#stage").min(axis=2) > 250)  # where the picture is white
    stage, height, width = live.find("#stage").rect, np.ptp(rows) + 1, np.ptp(columns) + 1
    assert abs(height - stage["height"]) <= 2 and abs(height - 2 * width) <= 4


HIGH = "data:image/svg+xml," + quote("""<svg xmlns='http://www.w3.org/2000/svg' width='1000' height='2000'>
    <path d='M0 0h1000v2000h-1000' fill='white'/></svg>""")


def test_old_hair_is_seen_also_where_strands_are_thinner_than_a_pixel(live, sized):
    sized(1280, 720)
    live.session.cook = lambda node, frame: None
    do(live.driver, "selectNode('hair'); app.set({ frame: 2 }); choosePreset('edit')")
    do(live.driver, "viewer.camera.distance *= 4; viewer.redraw()")
    lit = lambda: (lambda image: image.max(axis=2) - image.min(axis=2) > 12)(pixels(live.driver))  # noqa: E731
    live.until(lambda: lit().sum() > 100)
    before = lit()
    live.session.edit("hair.wave.height", "0.3125")
    live.until(lambda: live.ask("document.body.dataset.ghost") == "1")
    live.until(lambda: (lit() & before).sum() > 0.5 * before.sum())


def test_a_refusal_is_shown_without_moving_the_page(live):
    place = live.find("#stage").rect
    do(live.driver, "sayControls('picture.hair takes Strands, not Mesh')")
    assert live.find("#stage").rect == place and live.find("#controls .said").is_displayed()
    live.node("lag").click()
    assert live.find("#controls .said").text == ""
    do(live.driver, "choosePreset('look'); sayControls('no graph is seen to click on')")
    live.find("#stage").click()
    assert live.find("#controls .said").text == ""
    live.driver.execute_script("choosePreset('edit')")
