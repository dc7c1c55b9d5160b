"""The page in a real browser, frozen and live."""

import json
import subprocess

import numpy as np
import pytest

from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.api.shot import load
from hairpipe.app.api.source import shipped_graphs
from hairpipe.app.page.documents import graph_document
from hairpipe.app.page.report import write_report
from hairpipe.app.page.session import Session
from hairpipe.app.page.values import quantised

from ...pages import data_of
from ..cli.commands.test_watch import ELSEWHERE
from .conftest import SHOT, START
from .live_page import Page, do, pixels, served

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(folder):
    shot = load(folder / "shot.toml", cache=folder / "cache")
    write_report(shot, folder / "report")
    return (folder / "report" / "index.html").as_uri()


def requests(driver):
    """Addresses that were asked for."""
    events = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    return [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]


def test_a_frozen_page_needs_nothing_but_its_files(opened, report):
    driver = opened(report)
    for node in ("ball", "plate", "hair", "picture", "reach"):
        do(driver, "selectNode(arguments[0])", node)
    assert all(address.startswith(("file:", "data:")) for address in requests(driver)), requests(driver)
    assert [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"] == []
    assert driver.execute_script("return document.body.dataset.errors") == "0"


def test_one_file_holds_all_of_it(opened, shot, tmp_path):
    write_report(shot, tmp_path / "report.html", single=True)
    driver = opened((tmp_path / "report.html").as_uri())
    do(driver, "selectNode('picture')")
    assert driver.execute_script("return document.querySelector('.book img').naturalWidth") == 64
    assert [a for a in requests(driver) if not a.startswith("data:")] == [(tmp_path / "report.html").as_uri()]


def test_every_node_shows_its_result_when_clicked(shown, report):
    driver = shown(report)
    results = {"ball": ".slices canvas", "plate": "#view", "hair": "#view", "picture": ".book img"}
    for node, selector in (results | {"reach": ".table table"}).items():
        driver.find_element("css selector", f'[data-node="{node}"]').click()
        do(driver, "")
        assert driver.find_element("css selector", "#panel h2").text.startswith(node)
        assert driver.find_element("css selector", selector).is_displayed(), node


def test_strands_are_where_python_has_them_and_are_picked(shown, report, shot):
    driver = shown(report)
    do(driver, "selectNode('hair'); app.set({ frame: 2 })")
    places = np.array(driver.execute_script("return Array.from(viewer.items.at(-1).places)")).reshape(-1, 3)
    hair = shot.get("hair@2")
    assert np.abs(places - hair.points).max() <= 0.51 * quantised(hair.points)[1]["step"]
    script = """const p = arguments[0], { clientWidth: width, clientHeight: height } = viewer.canvas;
        const m = viewer.camera.matrix(width / height);
        const w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
        const at = [0, 1].map((k) => (m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]) / w);
        return viewer.pick((at[0] + 1) / 2 * width, (1 - at[1]) / 2 * height).strand;"""
    front = int(np.argmax(places.reshape(300, 12, 3)[:, -1, 2]))
    assert do(driver, script, places[12 * front + 11].tolist()) == front


def test_the_picture_moves_with_the_timeline_and_takes_colours(shown, report):
    driver = shown(report)
    do(driver, "selectNode('hair'); app.set({ frame: 1 })")
    first = pixels(driver)
    lit = (first.max(axis=2) - first.min(axis=2) > 25).mean()
    assert lit > 0.02, "hair is drawn"
    slider = driver.find_element("css selector", "#frame")
    do(driver, "arguments[0].value = 4; arguments[0].dispatchEvent(new Event('input'))", slider)
    second = pixels(driver)
    assert (np.abs(first - second).max(axis=2) > 30).mean() > 0.01
    names = driver.execute_script("return [...document.querySelectorAll('#choices button')].map((b) => b.innerText)")
    assert names == ["keep for comparison", "shaded", "strand", "speed", "stretch", "height [mm]"]
    for channel in ("strand", "speed", "height [mm]"):
        do(driver, "app.set({ channel: arguments[0] })", channel)
        assert (np.abs(pixels(driver) - second).max(axis=2) > 30).mean() > 0.01
    assert driver.find_element("id", "legend").text.split() == ["0.00", "200", "mm"]


def test_two_pictures_lie_below_a_slider(shown, report):
    driver = shown(report)
    do(driver, "selectNode('picture'); app.set({ frame: 1 })")
    driver.find_element("css selector", ".pin").click()
    do(driver, "app.set({ frame: 5 })")
    cut = "return document.querySelector('.then').style.clipPath"
    before = driver.execute_script(cut)
    do(driver, "const k = document.querySelector('.knife'); k.value = 900; k.dispatchEvent(new Event('input'))")
    assert (before, driver.execute_script(cut)) == ("inset(0px 50% 0px 0px)", "inset(0px 10% 0px 0px)")
    assert driver.find_element("css selector", ".which").text == "kept picture@1 | picture@5"


def test_tables_of_frames_become_curves_and_sort(shown, report):
    driver = shown(report)
    do(driver, "selectNode('reach')")
    rows = "return [...document.querySelectorAll('.table > table tbody tr')].map((row) => row.cells[0].textContent)"
    assert driver.execute_script(rows) == ["1", "2", "3", "4", "5"]
    head = driver.find_elements("css selector", ".table > table th")[0]
    head.click()
    head.click()
    assert driver.execute_script(rows) == ["5", "4", "3", "2", "1"]
    assert driver.find_element("css selector", ".uplot canvas").is_displayed()


def test_no_wire_crosses_a_node_in_any_shipped_graph(shown, report, find_data, monkeypatch):
    there = find_data(monkeypatch)
    driver = shown(report)
    script = """
        const [graph, state] = arguments;
        resolveTypes(graph);
        Object.assign(app, { graph, state });
        drawGraph();
        const nodes = [...document.querySelectorAll('#graph .node')];
        const boxes = nodes.map((node) => [node.dataset.node, node.querySelector('.box').getBBox()]);
        const crossed = new Set();
        for (const wire of document.querySelectorAll('#graph .wire'))
          for (const [x, y] of placesAlong(wire.getAttribute('d')))
            for (const [name, b] of boxes)
              if (x > b.x + 0.5 && x < b.x + b.width - 0.5 && y > b.y && y < b.y + b.height)
                crossed.add(`${wire.dataset.from} -> ${wire.dataset.to} crosses ${name}`);
        return [boxes.length, [...crossed]];

        function placesAlong(path) {
          let x = 0, y = 0;
          const places = [];
          for (const [, kind, numbers] of path.matchAll(/([MCH])([^MCH]*)/g)) {
            const n = numbers.trim().split(/\\s+/).map(Number);
            const end = kind === 'H' ? [n[0], y] : n.slice(-2);
            const [a, b] = kind === 'C' ? [n.slice(0, 2), n.slice(2, 4)] : [[x, y], end];
            for (let t = 0.05; t < 1.01 && kind !== 'M'; t += 0.05) {
              const s = 1 - t, [u, v, w] = [3 * s * s * t, 3 * s * t * t, t ** 3];
              const at = (k, p) => s ** 3 * p + u * a[k] + v * b[k] + w * end[k];
              places.push([at(0, x), at(1, y)]);
            }
            [x, y] = end;
          }
          return places;
        }"""
    for name, path in shipped_graphs().items():
        if data_of(path) and not there:
            continue
        shot = load(path)
        document, state = graph_document(shot), {"nodes": {node: {"cells": []} for node in shot.nodes}}
        # Settings of types, which nothing draws, take longer to send than the graph to draw; the descriptions are kept.
        document["types"] = {name: one | {"settings": []} for name, one in document["types"].items()}
        boxes, crossed = driver.execute_script(script, document, state)
        assert boxes == len(shot.nodes) and not crossed, (name, crossed)


def test_live_a_setting_is_edited_run_and_saved(live, folder):
    do(live.driver, "selectNode('picture')")
    cells = """Object.entries(app.state.nodes).flatMap(([node, { cells }]) =>
        cells.map(({ frame, outputs }) => [node, frame, JSON.stringify(outputs)]))"""
    edit = """const field = document.querySelector('[data-setting="red"] input');
        field.value = arguments[0]; field.dispatchEvent(new Event('change'))"""

    def wait_for_controls(text):
        idle = "document.querySelector('#controls').innerText.includes(arguments[0]) && !app.state.verdict.running"
        live.until(lambda: live.ask(idle, text), 30)

    before = set(map(tuple, live.ask(cells)))
    do(live.driver, edit, "7e400")
    live.until(lambda: live.all(".wrong") and live.find(".wrong").text)
    do(live.driver, "document.querySelector('.explain summary').click()")
    do(live.driver, edit, "0.875")
    wait_for_controls("picture.red = 0.875")
    assert live.ask("app.state.verdict.missing") in (4, 5)  # of the frame shown by itself, or not yet
    do(live.driver, "document.getElementById('do-run').click()")
    wait_for_controls("run save 1")
    changed = set(map(tuple, live.ask(cells))) - before
    assert sorted(cell[:2] for cell in changed) == [("picture", frame) for frame in range(1, 6)]
    assert live.ask("app.state.verdict.missing") == 0 and (folder / "shot.toml").read_text() == SHOT
    explained = "document.querySelector('.explain[open]')?.innerText.includes('0.875')"
    live.until(lambda: live.ask(explained))  # the box has stayed open, and tells of the new result
    do(live.driver, "document.getElementById('do-save').click()")
    wait_for_controls("run save revert")
    paint = '"paint"\nin.hair = "hair"\n'
    assert (folder / "shot.toml").read_text() == SHOT.replace(paint, f"{paint}red = 0.875\n")
    assert not live.has_errors


def test_live_a_run_of_another_process_is_followed(opened, shot, folder):
    changed = shot.changed({"hair.strands": 310})
    lease = folder / "cache" / "lease" / next(e.key for e in changed.plan() if str(e.task) == "hair@1")
    session = Session(shot)
    session.edit("hair.strands", "310")
    session.cook = lambda node, frame: None
    with served(session) as address:
        page = Page(opened(address), session)
        do(page.driver, "selectNode('hair'); app.set({ frame: 1 })")
        lease.parent.mkdir(exist_ok=True)
        lease.write_text(json.dumps({"holder": ELSEWHERE, "host": "render-7"}))
        page.until(lambda: page.ask("app.cell('hair').state") == "running", 30)
        assert "computing: render-7 1" in page.find("#verdict").text
        assert page.find("#panel .state").text == "hair@1: running on render-7"
        lease.unlink()
        run = [*START, "run", "shot.toml", "--set", "hair.strands=310", "--to", "hair", "-j1", "-q"]
        subprocess.run(run, cwd=folder, check=True)
        page.until(lambda: page.ask("viewer?.items.at(-1)?.places.length") == 310 * 12 * 3, 30)
        assert page.ask("app.cell('hair').state") == "cached" and not page.has_errors


@pytest.mark.slow
def test_live_an_edit_shows_the_selected_node_by_itself_and_names_what_a_run_costs(live):
    do(live.driver, "selectNode('hair'); app.set({ frame: 3 })")
    live.session.edit("hair.strands", "211")
    live.settle()
    found = """return document.querySelector('[data-setting="strands"] input[type=range]')"""
    slider = live.driver.execute_script(found)  # which is not found again
    live.until(lambda: live.ask("viewer.items.at(-1)?.lengths?.length") == 211)
    assert slider.is_displayed(), "only the state in the panel was drawn again"
    live.until(lambda: "hair 4" in live.find("#panel .ahead").text)
    do(live.driver, "selectNode('lag')")
    live.until(lambda: "waits for a run: simulation lag" in live.find("#panel .ahead").text)
    live.find("#run-to").click()
    live.until(lambda: live.ask("app.cell('lag').state") in ("computed", "cached"), 40)
    assert live.ask("app.cell('reach').state") == "run"


@pytest.mark.slow
def test_live_a_slider_that_is_dragged_shows_its_result_and_is_one_edit_on_release(live):
    do(live.driver, "selectNode('hair'); app.set({ frame: 3 })")
    text, steps = live.text, len(live.session._history.document()["edits"])
    strands = "return viewer.items.at(-1)?.lengths?.length"
    live.until(lambda: live.driver.execute_script(strands) == 300)
    slider = live.find('[data-setting="strands"] input[type=range]')
    drag = "const [slider, place] = arguments; slider.value = place; slider.dispatchEvent(new Event('input'))"
    seen = set()
    for place in (620, 640, 660):
        live.driver.execute_script(drag, slider, place)
        value = int(live.find('[data-setting="strands"] input').get_attribute("value"))
        live.until(lambda value=value: live.driver.execute_script(strands) == value)
        seen.add(value)
    assert len(seen) == 3 and live.text == text
    live.driver.execute_script("arguments[0].dispatchEvent(new Event('change'))", slider)
    live.until(lambda: live.tables["hair"]["strands"] == value)
    assert len(live.session._history.document()["edits"]) == steps + 1
    assert live.ask("[viewer.items.at(-1).lengths.length, app.trial]") == [value, None]
    assert live.session.document("state")[0]["nodes"]["hair"]["cells"][2]["state"] in ("cached", "computed")
    live.driver.execute_script(drag, live.find('[data-setting="strands"] input[type=range]'), 620)
    live.until(lambda: live.ask("app.trial !== null"))
    live.driver.execute_script("dropTrial()")  # as a release where the drag began
    live.until(lambda: live.ask("app.trial") is None)
    live.until(lambda: live.driver.execute_script(strands) == value)


def test_live_the_last_result_stays_in_view_and_is_marked(live):
    live.session.cook = lambda node, frame: None
    stale = lambda: [one.text for one in live.driver.find_elements("id", "stale")]  # noqa: E731
    do(live.driver, "selectNode('picture'); app.set({ frame: 2 })")
    shown = live.find(".book img").get_attribute("src")
    live.session.edit("picture.red", "0.77")
    live.until(lambda: stale() == ["stale: before the edit"])
    assert live.find(".book img").get_attribute("src") == shown
    do(live.driver, "selectNode('hair')")
    assert stale() == []
    live.session.change("shot", {"name": "frames", "text": "[1, 6]"})
    live.until(lambda: live.ask("app.graph.frames[1]") == 6)
    do(live.driver, "app.set({ frame: 6 })")
    live.until(lambda: stale() == ["stale: frame 2"])
    assert live.ask("[viewer.items.length, viewer.ghost.at(-1).lengths.length]") == [0, 300]
    do(live.driver, "app.last.clear(); selectNode('reach')")
    live.until(lambda: stale() == ["stale: frame 5"])
    assert live.find(".table table").is_displayed(), "the nearest frame, where nothing was shown before"
    assert not live.has_errors


SEARCH = """const [text, done] = arguments;
hairpipe.plain("catalogue").then(({ types }) =>
  done(ranked(types, text).map(({ type, setting }) => [type.name, categoryOf(type), setting])));"""


@pytest.mark.parametrize(
    "text, name, category, setting",
    [
        ("wind", "simulate_hair", "simulate", "air"),
        ("collision", "simulate_hair", "simulate", "contact"),
        ("curl", "grow_groom", "groom", "curl"),
        ("import", "load_body", "import", ""),
        ("friction", "simulate_hair", "simulate", "contact.friction"),
        ("sdf", "bake_levelset", "levelset", ""),
    ],
)
def test_live_nodes_are_found_by_settings_and_words_of_other_programs(looked, text, name, category, setting):
    found = {one[0]: one[1:] for one in looked.driver.execute_async_script(SEARCH, text)}
    assert name in found and found[name][0] == category and found[name][1].startswith(setting)
    assert "flipbook" not in found


def test_live_the_middle_button_turns_the_view_and_a_double_click_shows_all(looked):
    do(looked.driver, "selectNode('hair'); app.set({ frame: 1 })")
    state = "const { yaw, target, distance } = viewer.camera; return [yaw, target, distance]"
    yaw, target, distance = looked.driver.execute_script(state)
    looked.driver.execute_script(
        """for (const [type, x] of [["pointerdown", 100], ["pointermove", 160], ["pointerup", 160]])
        viewer.canvas.dispatchEvent(new PointerEvent(type, { button: 1, clientX: x, clientY: 100, pointerId: 1 }));
        viewer.camera.distance *= 5;"""
    )
    turned, same, _ = looked.driver.execute_script(state)
    assert turned != yaw and same == target
    looked.driver.execute_script("viewer.canvas.dispatchEvent(new MouseEvent('dblclick'))")
    assert looked.driver.execute_script(state)[2] < 2 * distance


def test_live_an_empty_graph_offers_templates(opened, tmp_path):
    session = Session(load_draft(str(tmp_path / "new.toml"), EMPTY, cache=tmp_path / "cache"))
    session.cook = lambda node, frame: None
    with served(session) as address:
        page = Page(opened(address), session)
        lacks = {"demo": set(), "bust with fringe": set(), "bust in motion": {"motion"}, "my character": {"head"}}
        for title, files in lacks.items():
            page.find(f'[data-template="{title}"]').click()
            page.until(lambda: len(session.draft.tables) > 1)
            assert not page.all("#templates")
            faults = {name for name, fault in session.draft.faults.items() if "is incomplete" not in fault}
            assert faults == files
            page.ask("edit('undo')")
            page.until(lambda: page.all("#templates"))
