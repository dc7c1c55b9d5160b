"""The viewport of the page in a real browser: strands are picked, and what was drawn is not made again."""

import numpy as np
import pytest

from hairpipe.app.page.values import quantised

from .live_page import do, pixels

pytestmark = pytest.mark.slow
PLACE = """const p = arguments[0], { clientWidth: width, clientHeight: height } = viewer.canvas;
    const m = viewer.camera.matrix(width / height), w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
    const at = [0, 1].map((k) => (m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]) / w);
    return [(at[0] + 1) / 2 * width, (1 - at[1]) / 2 * height];"""
"""Pixel of the viewport at a place."""


def click(page, place):
    """Click on a place of the scene."""
    canvas = page.find("#view")
    x, y = page.driver.execute_script(PLACE, list(map(float, place)))
    offset = int(x - canvas.rect["width"] / 2), int(y - canvas.rect["height"] / 2)
    page.actions().move_to_element_with_offset(canvas, *offset).click().perform()
    do(page.driver, "")


def facts(page):
    """What is told about the picked strand, by name."""
    names, values = (page.all(f"#picked {tag}") for tag in ("dt", "dd"))
    return {name.text: value.text for name, value in zip(names, values, strict=True)}


def test_a_strand_is_picked_described_and_let_go(live, shot):
    driver = live.driver
    do(driver, "selectNode('hair'); app.set({ frame: 2 })")
    before = pixels(driver)
    hair = shot.get("hair@2")
    points = hair.points.reshape(300, 12, 3)
    front = int(np.argmax(points[:, -1, 2]))
    click(live, points[front, -1])
    live.until(lambda: live.all("#picked"))
    told = facts(live)
    assert told["strand"] == f"{front} of 300, 12 points"
    step = quantised(hair.points)[1]["step"]
    assert np.abs(np.array(told["root"].split()[:3], float) - points[front, 0]).max() <= step + 1e-4
    length = np.linalg.norm(np.diff(points[front], axis=0), axis=1).sum()
    assert float(told["length"].split()[0]) == pytest.approx(1e3 * length, abs=1e3 * 12 * step)
    assert told["made by"].startswith("hair swing in shot.toml")
    depths = shot.get("height@2")
    own = depths.values[0][depths.offsets[front] : depths.offsets[front + 1]].max()
    assert float(told[f"most {depths.names[0]}"]) == pytest.approx(own, rel=0.02)
    marked = (np.abs(pixels(driver) - before).max(axis=2) > 60) & (pixels(driver)[..., 2] > 180)
    assert 20 < marked.sum() < 0.05 * marked.size
    do(driver, "app.set({ frame: 4 })")
    then = shot.get("hair@4").points.reshape(300, 12, 3)[front]
    length = pytest.approx(1e3 * np.linalg.norm(np.diff(then, axis=0), axis=1).sum(), abs=1e3 * 12 * step)
    assert float(told["length"].split()[0]) != length
    live.until(lambda: float(facts(live).get("length", "nan").split()[0]) == length)
    assert facts(live)["strand"] == told["strand"]
    live.press(live.Keys.ESCAPE)
    assert not live.all("#picked")
    click(live, shot.get("hair@4").points.reshape(300, 12, 3)[front, -1])
    live.until(lambda: live.all("#picked"))
    canvas = live.find("#view")
    corner = 4 - int(canvas.rect["width"] / 2), 4 - int(canvas.rect["height"] / 2)
    live.actions().move_to_element_with_offset(canvas, *corner).click().perform()
    live.until(lambda: not live.all("#picked"))


def test_frames_that_were_drawn_are_not_uploaded_again(live):
    driver = live.driver
    do(driver, "selectNode('hair')")
    for frame in (1, 2, 3):
        do(driver, "app.set({ frame: arguments[0] })", frame)
    live.until(lambda: live.ask("viewer.kept.size") >= 4)  # three of hair, and the plate
    uploads = live.ask("viewer.scene.work.uploads")
    faces = live.ask("viewer.scene.faces.size")
    for frame in (1, 2, 3, 2):
        do(driver, "app.set({ frame: arguments[0] })", frame)
    do(driver, "viewer.camera.yaw += 0.3; viewer.redraw()")
    assert live.ask("viewer.scene.work.uploads") == uploads and faces == 1
    calls = live.ask("viewer.scene.work.calls")
    do(driver, "viewer.redraw()")
    assert live.ask("viewer.scene.work.calls") == calls + 2


def test_the_number_of_shown_strands_is_chosen_and_kept(live):
    driver = live.driver
    shown = "return [viewer.items.at(-1).document?.split('@')[1], viewer.items.at(-1).lengths?.length]"
    do(driver, "selectNode('hair'); STRANDS_SHOWN[1] = 120; drawChoices()")
    live.until(lambda: driver.execute_script(shown) == ["4000", 300])
    work = live.ask("{ ...viewer.scene.work }")
    driver.find_element("css selector", "#strands option[value='120']").click()
    live.until(lambda: driver.execute_script(shown) == ["120", 120])
    spent = {name: value - work[name] for name, value in live.ask("viewer.scene.work").items()}
    points = 120 * 12
    assert spent["uploads"] == 2 and spent["bytes"] == 6 * (points + 3) + 4 * (points + 2)
    dark = pixels(driver)[4, 4]
    driver.find_element("id", "backdrop").click()
    do(driver, "")
    assert (pixels(driver)[4, 4] > dark + 50).all()
    assert "120 of 300 strands shown" in driver.find_element("id", "note").text
    assert live.ask("localStorage.getItem(STRANDS_KEPT)") == "120"
    for text in ("null", "{", "[1]"):
        driver.execute_script("localStorage.setItem(KEPT, arguments[0]); listenToPanes()", text)
    driver.execute_script("localStorage.clear()")


def test_a_kept_result_stays_and_hides_nothing_else(live):
    driver = live.driver
    ghost = lambda: live.ask("document.body.dataset.ghost")  # noqa: E731
    hair = lambda items: driver.execute_script(f"return viewer.{items}.at(-1).document")  # noqa: E731
    live.session.cook = lambda node, frame: None
    do(driver, "selectNode('hair'); app.set({ frame: 2 })")
    live.until(lambda: live.ask("viewer.items.at(-1)?.document"))
    before = hair("items")
    live.find("#choices .pin").click()
    live.until(lambda: ghost() == "2")
    for node, shown in (("picture", ".book img"), ("reach", ".table")):
        do(driver, "selectNode(arguments[0])", node)
        live.until(lambda shown=shown: live.all(f"#stage {shown}"))
        assert not live.find("#view").is_displayed() and not live.find("#knife").is_displayed()
    do(driver, "selectNode('hair')")
    live.session.edit("hair.strands", "310")
    live.until(lambda: ghost() == "1")
    assert live.find("#stale").text == "stale: before the edit"
    live.until(lambda: not live.find("#knife").is_displayed())
    live.find("#do-run").click()
    live.until(lambda: ghost() == "2", 60)
    assert live.find("#note").text == "kept hair@2 | hair@2"
    assert hair("ghost") == before != hair("items")
    do(driver, "app.set({ channel: 'height [mm]' })")
    values = "return [comparison().layers, layersOf('hair', '')].map((layers) => layers.at(-1).values[0])"
    kept, selected = driver.execute_script(values)
    assert kept and selected and kept != selected, "each is coloured by the values of its own strands"


def test_two_frames_are_compared_with_one_camera(live, shot):
    driver = live.driver
    do(driver, "choosePreset('look'); selectNode('hair'); app.set({ frame: 2 })")
    live.find("#choices .pin").click()
    live.until(lambda: live.ask("document.body.dataset.ghost") == "2")
    assert live.find("#knife").is_displayed()
    do(driver, "app.set({ apart: true })")
    live.until(lambda: not live.find("#knife").is_displayed())

    def halves():
        image = pixels(driver)[: pixels(driver).shape[0] // 2]  # without the words below
        half = image.shape[1] // 2
        return image[:, 4 : half - 4], image[:, image.shape[1] - half + 4 : image.shape[1] - 4]

    def differ():
        left, right = halves()
        return (np.abs(left - right).max(axis=2) > 30).mean()

    lit = halves()[0]
    assert (lit.max(axis=2) - lit.min(axis=2) > 25).mean() > 0.01 and differ() < 1e-3
    do(driver, "app.set({ frame: 4 })")
    live.until(lambda: live.find("#note").text == "kept hair@2 | hair@4")
    assert differ() > 0.01
    places = [shot.get(f"hair@{frame}").points for frame in (2, 4)]
    apart = 1e3 * np.linalg.norm(places[1] - places[0], axis=1)
    do(driver, "app.set({ channel: DIFFERENCE })")
    live.until(lambda: live.find("#legend").text.endswith("mm"))
    step = 1e3 * quantised(places[1])[1]["step"]
    assert float(live.find("#legend").text.split()[1]) == pytest.approx(apart.max(), rel=5e-3, abs=2 * step)
    script = """const done = arguments[0], of = (frame) => hairpipe.get(app.document("hair", "", "strands", frame));
        Promise.all([of(4), of(2)]).then(([found, other]) => done(Array.from(differencesOf(found, other).values)));"""
    found = np.array(driver.execute_async_script(script)) * apart.max()
    assert np.abs(found - apart).max() < 5 * step
    do(driver, "app.set({ channel: 'speed' })")
    live.until(lambda: live.find("#legend").text.endswith("m/s"))
    script = """const done = arguments[0], hair = [viewer.ghost, viewer.items].map((items) => items.at(-1).document);
        Promise.all(hair.map(hairpipe.get)).then((both) => done(both.map((one) => one.meta.fastest)));"""
    fastest = driver.execute_async_script(script)
    assert fastest[0] != fastest[1]
    assert float(live.find("#legend").text.split()[1]) == pytest.approx(max(fastest), rel=5e-3)
    x, y = live.ask("[viewer.canvas.clientWidth / 4, viewer.canvas.clientHeight / 2]")
    assert live.ask("viewer.pick(arguments[0], arguments[1])", x, y) is None
    live.find("#choices .pin").click()
    live.until(lambda: live.ask("document.body.dataset.ghost") == "0")
    driver.execute_script("localStorage.clear()")
