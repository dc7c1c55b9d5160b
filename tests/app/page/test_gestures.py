"""The gestures of the live page in a real browser: each changes the text of the graph file as a person would have."""

import pytest

from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.page.session import Session

from .conftest import SHOT
from .live_page import SOCKET, Page, do, pixels, served

pytestmark = pytest.mark.slow


def test_an_empty_project_becomes_a_simulation_without_typing_toml(opened, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(folder)
    session = Session(load_draft("fringe.toml", EMPTY.replace("24]", "2]"), cache=tmp_path / "cache"))
    with served(session) as address:
        page = Page(opened(address), session)
        for name in ("make_plate", "swing"):
            page.actions().move_to_element(page.find("#graph")).perform()
            page.press("a", page.Keys.SHIFT)
            page.choose(name)
            page.until(lambda name=name: name.rpartition("_")[2] in page.tables)
        page.press("l")
        page.until(lambda: "layout" not in page.tables)
        page.drag(page.find(SOCKET.format("swing", "out")), by=(120, 60))
        page.until(lambda: page.all("#popup li"))
        assert page.find("#popup input").get_attribute("placeholder") == "node that takes Strands"
        page.choose("trail")
        page.until(lambda: page.tables.get("trail", {}).get("in") == {"hair": "swing"})
        page.find("#do-run").click()
        page.until(lambda: page.ask("viewer?.items.at(-1)?.lengths?.length") == 200, 60)
        page.press("s", page.Keys.CONTROL)
        page.until(lambda: (folder / "fringe.toml").exists())
        assert not page.has_errors
    assert (folder / "fringe.toml").read_text().partition("[layout]")[0] == EMPTY.replace("24]", "2]") + (
        '\n[plate]\ntype = "make_plate"\n\n[swing]\ntype = "swing"\nin.plate = "plate"\n\n'
        '[trail]\ntype = "trail"\nin.hair = "swing"\n\n'
    )
    (folder / "fringe.toml").unlink()


def test_wires_are_cut_connected_and_refused(undone):
    undone.drag(undone.find(SOCKET.format("picture", "in")), by=(-40, 70))
    undone.until(lambda: "in" not in undone.tables["picture"])
    undone.drag(undone.find(SOCKET.format("plate", "out")), undone.find(SOCKET.format("picture", "in")))
    assert undone.ask("document.body.dataset.refused") == "picture.hair takes Strands, not Mesh"
    undone.drag(undone.find(SOCKET.format("lag", "out")), undone.find(SOCKET.format("picture", "in")))
    undone.until(lambda: undone.tables["picture"].get("in") == {"hair": "lag"})


def test_nodes_are_moved_muted_copied_renamed_and_deleted_and_all_of_it_undone(undone):
    undone.drag(undone.node("ball"), by=(30, 40))
    undone.until(lambda: "ball" in undone.tables.get("layout", {}))
    undone.node("lag").click()
    undone.press("m")
    undone.until(lambda: undone.tables["lag"].get("mute") is True)
    undone.press("d", undone.Keys.SHIFT)
    undone.until(lambda: "lag_2" in undone.tables)
    undone.press(undone.Keys.F2)
    undone.choose("late")
    undone.until(lambda: "late" in undone.tables)
    undone.press("x")
    undone.until(lambda: "late" not in undone.tables)
    after = undone.text
    for _ in range(5):
        depth = undone.session._history.at
        undone.press("z", undone.Keys.CONTROL)
        undone.until(lambda depth=depth: undone.session._history.at == depth - 1)
    assert undone.text == SHOT
    for _ in range(5):
        depth = undone.session._history.at
        undone.press("z", undone.Keys.CONTROL, undone.Keys.SHIFT)
        undone.until(lambda depth=depth: undone.session._history.at == depth + 1)
    assert undone.text == after


def test_a_box_chooses_nodes_that_are_deleted_together(undone):
    graph = undone.find("#graph")
    corner = -graph.rect["width"] / 2 + 3, -graph.rect["height"] / 2 + 3
    actions = undone.actions().key_down(undone.Keys.SHIFT).move_to_element_with_offset(graph, *map(int, corner))
    actions.click_and_hold().move_to_element(graph).move_to_element_with_offset(graph, *(int(-c) for c in corner))
    actions.release().key_up(undone.Keys.SHIFT).perform()
    assert len(undone.ask("[...app.chosen]")) == 7
    undone.press(undone.Keys.DELETE)
    undone.until(lambda: not {"hair", "ball"} & undone.tables.keys())
    assert "adds a node" in undone.find("#panel").text


def test_groups_are_switched_and_values_unset(undone):
    do(undone.driver, "selectNode('hair')")
    undone.find('[data-group="wave"] input[type=checkbox]').click()
    undone.until(lambda: undone.tables["hair"]["wave"] is False)
    undone.find("details.absent summary").click()
    undone.find('details.absent [data-group="wave"] input').click()
    undone.until(lambda: "wave" not in undone.tables["hair"])
    undone.find('[data-setting="strands"] .unset').click()
    undone.until(lambda: "strands" not in undone.tables["hair"])


def choose_action(live, target, name):
    live.actions().context_click(target).perform()
    live.until(lambda: live.all("#popup.menu"))
    live.find(f'#popup.menu [data-action="{name}"]').click()
    assert not live.all("#popup.menu")


def test_a_right_click_opens_the_actions_of_a_node_and_of_the_graph(undone):
    choose_action(undone, undone.node("picture"), "mute or unmute")
    undone.until(lambda: undone.tables["picture"].get("mute"))
    assert undone.ask("[app.node, ...app.chosen]") == ["picture", "picture"]
    choose_action(undone, undone.node("lag"), "rename")
    undone.choose("later")
    undone.until(lambda: "later" in undone.tables)
    undone.session.edit("hair.strands", "240")
    undone.settle()
    choose_action(undone, undone.node("hair"), "run to this node")
    undone.until(lambda: undone.ask("app.cell('hair').state") in ("computed", "cached"), 40)
    choose_action(undone, undone.node("later"), "delete")
    undone.until(lambda: "later" not in undone.tables)
    do(undone.driver, "showAll()")
    graph = undone.find("#graph")
    corner = [3 - int(graph.rect[side] / 2) for side in ("width", "height")]
    undone.actions().move_to_element_with_offset(graph, *corner).context_click().perform()
    undone.until(lambda: undone.all("#popup.menu"))
    undone.actions().send_keys(undone.Keys.ENTER).perform()  # the first action
    undone.choose("make_ball")
    undone.until(lambda: "ball_2" in undone.tables)
    assert not undone.has_errors


def test_keys_move_and_fold_nodes_and_close_the_settings(undone):
    undone.node("hair").click()
    place = undone.ask("boxOfNode('hair')")
    undone.press("g")
    undone.actions().move_to_element(undone.node("hair")).move_by_offset(40, 25).perform()
    assert undone.ask("boxOfNode('hair').x === arguments[0] && held.moved", place["x"])
    undone.press(undone.Keys.ESCAPE)
    assert undone.ask("[boxOfNode('hair').x, held]") == [place["x"], None]
    undone.press("g")
    undone.actions().move_to_element(undone.node("hair")).move_by_offset(-30, 10).click().perform()
    undone.until(lambda: "hair" in undone.tables.get("layout", {}))
    assert undone.tables["layout"]["hair"][0] < place["x"]
    text = undone.text
    high = undone.node("hair").rect["height"]
    undone.press("h")
    assert undone.node("hair").rect["height"] < 0.6 * high and undone.text == text
    undone.press("h")
    assert undone.node("hair").rect["height"] == high
    undone.actions().move_to_element(undone.find("#graph")).perform()
    undone.press(undone.Keys.TAB)
    assert not undone.find("#panel").is_displayed()
    undone.press(undone.Keys.TAB)
    assert undone.find("#panel").is_displayed()
    undone.press("?", undone.Keys.SHIFT)
    listed = [one.text for one in undone.all("#keys dt")]
    assert {"G", "H", "B", "Tab", "Home", "Shift-D", "Ctrl-S"} <= set(listed)
    undone.find("#keys").click()


def test_every_category_of_nodes_has_an_icon(looked):
    script = """const done = arguments[0];
    hairpipe.plain("catalogue").then(({ types }) => done(types.map((type) => [type.name, categoryOf(type)])));"""
    icons = looked.ask("Object.keys(ICONS)")
    without = {category for _, category in looked.driver.execute_async_script(script) if category not in icons}
    assert without <= {"normals", "pins", "pointvalues"}
    assert len(looked.all("#graph .node .icon")) == 7


@pytest.mark.parametrize("size", [(1440, 900), (1280, 720)])
def test_hair_is_at_the_top_left_above_the_fold(looked, size):
    driver = looked.driver
    metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        do(driver, "selectNode('hair')")
        stage, graph = looked.find("#stage").rect, looked.find("#graph").rect
        assert stage["x"] == 0 and stage["y"] < 90 and stage["height"] > 0.33 * size[1]
        assert graph["y"] + graph["height"] < size[1] and looked.find("#strip").rect["y"] < size[1] - 40
    finally:
        driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_nodes_are_copied_and_pasted_as_toml(undone):
    undone.node("hair").click()
    undone.actions().key_down(undone.Keys.SHIFT).click(undone.node("lag")).key_up(undone.Keys.SHIFT).perform()
    undone.press("c", undone.Keys.CONTROL)
    undone.actions().move_to_element(undone.find("#graph")).perform()
    undone.press("v", undone.Keys.CONTROL)
    undone.until(lambda: {"hair_2", "lag_2"} <= undone.tables.keys())
    assert undone.tables["lag_2"]["in"] == {"hair": "hair_2"} and "in" not in undone.tables["hair_2"]
    assert undone.text.count("# What is shown.\n[hair") == 2 and {"hair_2", "lag_2"} <= undone.tables["layout"].keys()
    paste = """const data = new DataTransfer();
        data.setData("text/plain", arguments[0]);
        document.dispatchEvent(new ClipboardEvent("paste", { clipboardData: data }));"""
    text = undone.text
    do(undone.driver, paste, "A sentence, from a letter.")
    undone.until(lambda: "TOML" in undone.ask("document.body.dataset.refused"))
    assert undone.text == text


def test_frames_and_notes_are_made_moved_and_removed(undone):
    undone.node("hair").click()
    undone.press("f")
    undone.until(lambda: undone.all("#popup input"))
    undone.actions().send_keys("All of it" + undone.Keys.ENTER).perform()
    undone.until(lambda: undone.tables.get("layout", {}).get("frame") == {"title": "All of it", "nodes": ["hair"]})
    undone.drag(undone.find(".frame .title"), by=(12, 30))
    undone.until(lambda: "hair" in undone.tables["layout"])
    graph = undone.find("#graph")
    undone.actions().move_to_element_with_offset(graph, int(-graph.rect["width"] / 2) + 12, 0).perform()
    undone.press("n")
    undone.until(lambda: undone.all("#popup input"))
    undone.actions().send_keys("swings slowly" + undone.Keys.ENTER).perform()
    undone.until(lambda: undone.tables["layout"].get("note", {}).get("text") == "swings slowly")
    place = undone.tables["layout"]["note"]["at"]
    undone.drag(undone.find(".note .back"), by=(20, 20))
    undone.until(lambda: undone.tables["layout"]["note"]["at"] != place)
    undone.press("x")
    undone.until(lambda: "note" not in undone.tables["layout"])
    assert undone.tables["hair"]["strands"] == 300


def test_all_nodes_are_chosen_laid_out_and_shown(undone):
    undone.actions().move_to_element(undone.find("#graph")).click().perform()
    chosen = "return app.chosen.size"
    do(undone.driver, "app.chosen = new Set(); paintGraph()")
    undone.press("a")
    assert undone.driver.execute_script(chosen) == 7
    undone.press("a")
    assert undone.driver.execute_script(chosen) == 0
    shown = "return document.getElementById('graph').getAttribute('viewBox')"
    box = undone.driver.execute_script(shown)
    scroll = """arguments[0].dispatchEvent(new WheelEvent("wheel", { deltaY: 400, clientX: 300, clientY: 500 }))"""
    do(undone.driver, scroll, undone.find("#graph"))
    assert undone.driver.execute_script(shown) != box
    undone.press(undone.Keys.HOME)
    assert undone.driver.execute_script(shown) == box


def test_old_hair_stays_until_there_is_new_hair_and_is_compared(live, folder):
    def lit():
        image = pixels(live.driver)
        return (image.max(axis=2) - image.min(axis=2) > 25).mean()

    live.session.cook = lambda node, frame: None
    do(live.driver, "selectNode('hair'); app.set({ frame: 2 })")
    live.until(lambda: lit() > 0.002)
    before = lit()
    live.session.edit("hair.wave.height", "0.2")
    live.until(lambda: live.ask("document.body.dataset.ghost") == "1")
    live.until(lambda: 0.002 < lit() < before)
    live.find("#do-run").click()
    live.until(lambda: live.ask("document.body.dataset.ghost") == "0", 60)
    live.driver.execute_script("choosePreset('compare')")
    live.until(lambda: live.ask("document.body.dataset.ghost") == "2")
    assert live.find("#knife").is_displayed()
    live.driver.execute_script("choosePreset('edit')")


def test_bars_change_the_panes_which_are_remembered(live):
    width = live.find("#panel").rect["width"]
    live.drag(live.find("#bar-side"), by=(-60, 0))
    assert abs(live.find("#panel").rect["width"] - width - 60) < 8
    live.driver.refresh()
    live.until(lambda: live.ask("document.body.dataset.state") == "ready")
    assert abs(live.find("#panel").rect["width"] - width - 60) < 8
    live.driver.execute_script("choosePreset('edit')")


def test_a_conflict_is_shown_and_ended(live, folder):
    live.session.edit("picture.red", "0.75")
    (folder / "shot.toml").write_text(SHOT.replace("strands = 300", "strands = 250"))
    live.until(lambda: live.all("#conflict .theirs"))
    live.find('[data-keep="both"]').click()
    live.until(lambda: not live.all("#conflict"))
    assert live.tables["hair"]["strands"] == 250 and live.tables["picture"]["red"] == 0.75


def test_edits_are_listed_and_saved_as_a_new_file(live, folder):
    live.session.edit("picture.red", "0.75")
    live.session.edit("hair.strands", "250")
    live.settle()
    place = live.find("#stage").rect
    live.find("#controls .edits summary").click()
    assert live.find("#controls .edits .list").text.splitlines() == ["picture.red = 0.75", "hair.strands = 250"]
    assert live.find("#stage").rect == place, "the list lies above the page"
    live.press("s", live.Keys.CONTROL, live.Keys.SHIFT)
    live.choose("../out.toml")
    live.until(lambda: live.ask("document.body.dataset.refused ?? ''"))
    live.find("#do-save-as").click()
    live.choose("copy.toml")
    live.until(lambda: (folder / "copy.toml").exists())
    assert "strands = 250 # three hundred" in (folder / "copy.toml").read_text()
    live.until(lambda: not live.all("#controls .edits"))
    (folder / "copy.toml").unlink()
