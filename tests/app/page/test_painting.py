"""Maps are painted on a body: in a real browser, and by requests of the server."""

import base64
import resource
import shutil
import tomllib

import numpy as np
import pytest

import hairpipe
from hairpipe.app.api.draft import load_draft
from hairpipe.app.page.session import Session
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import read_image

from .live_page import Page, do, pixels, served
from .test_viewport import PLACE

GRAPH = """schema = 1
frames = [1, 1]
fps = 24

[skin]
type = "make_skin"

[hair]
type = "stubble"
in.skin = "skin"
length = 0.03 # three centimetres
density = { map = "scalp" }
"""


@pytest.fixture
def session(folder):
    path = folder / "painted.toml"
    path.write_text(GRAPH)
    shot = hairpipe.load(path, cache=folder / "cache")
    assert shot.run(jobs=1).ok
    session = Session(shot)
    yield session
    session.close()
    shutil.rmtree(folder / "paint", ignore_errors=True)


def stroke(session, target, values):
    session.stroke({"target": target, "height": len(values), "values": base64.b64encode(values.tobytes()).decode()})


def given(session):
    return tomllib.loads(session._history.text)["hair"]


def test_a_stroke_is_a_picture_next_to_the_graph_and_one_step(session, folder):
    values = np.arange(64, dtype=np.uint8).reshape(8, 8)
    stroke(session, "hair.length", values)
    assert given(session)["length"] == {"value": 0.03, "image": "paint/hair_length_1.png"}
    assert "# three centimetres" in session._history.text
    assert np.array_equal(read_image(folder / "paint/hair_length_1.png"), values / 255.0)
    stroke(session, "hair.length", values)
    assert given(session)["length"]["image"] == "paint/hair_length_2.png"
    session.undo()
    stroke(session, "hair.density", values)
    assert given(session)["density"] == {"image": "paint/hair_density_1.png"}
    graph, _ = session.document("graph")
    assert graph["edits"] == ["paint hair.length", "paint hair.density"] and graph["revision"] == session.drawn
    session.undo()
    session.undo()
    assert session._history.text == GRAPH
    session.undo(1)
    session.save()
    session.close()
    assert [path.name for path in (folder / "paint").iterdir()] == ["hair_length_1.png"]


def test_a_saved_picture_stays_when_another_file_is_written(session, folder):
    stroke(session, "hair.length", np.zeros((4, 4), np.uint8))
    session.save()
    session.undo()
    session.save_as("other.toml")
    session.close()
    assert "hair_length_1.png" in (folder / "painted.toml").read_text()
    assert (folder / "paint" / "hair_length_1.png").exists()
    (folder / "other.toml").unlink()


def test_nothing_is_written_next_to_a_shipped_graph():
    with pytest.raises(BadInput, match="not a file of yours"):
        load_draft("demo").write_new("paint/groom_length_1.png", b"")


def test_a_picture_that_does_not_fit_on_the_disk_leaves_no_file(session, folder):
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, limits[1]))
    try:
        with pytest.raises(BadInput, match="cannot be written"):
            stroke(session, "hair.length", np.random.default_rng(1).integers(0, 255, (64, 64), np.uint8))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not list(folder.glob("paint/*")) and session._history.text == GRAPH


def test_other_settings_and_broken_values_are_not_painted_and_no_file_is_written(session, folder):
    for target in ("hair", "hair.shade", "skin.bare", "hare.length", "hair.length.value", "../x"):
        with pytest.raises(BadInput):
            stroke(session, target, np.zeros((4, 4), np.uint8))
    for values in ("AAAA", "not base64", "", 3):
        with pytest.raises((ValueError, TypeError)):  # which the server refuses as no request of the page
            session.stroke({"target": "hair.length", "height": 2, "values": values})
    assert not list(folder.glob("paint/*")) and session._history.text == GRAPH


def test_a_folder_that_is_a_link_out_of_the_project_is_refused(session, folder, tmp_path):
    (folder / "paint").symlink_to(tmp_path)
    try:
        with pytest.raises(BadInput, match="leaves"):
            stroke(session, "hair.length", np.zeros((4, 4), np.uint8))
        assert not list(tmp_path.iterdir())
    finally:
        (folder / "paint").unlink()


def drag(page, *places):
    """Drag on the body from place to place [m]."""
    canvas = page.find("#view")
    actions = page.actions()
    for number, place in enumerate(places):
        x, y = page.driver.execute_script(PLACE, list(place))
        offset = round(x - canvas.rect["width"] / 2), round(y - canvas.rect["height"] / 2)
        actions.move_to_element_with_offset(canvas, *offset)
        if number == 0:
            actions.click_and_hold()
    actions.release().perform()


def begin(page):
    """Choose the hair, and begin to paint."""
    do(page.driver, "selectNode('hair')")
    page.find("#paint").click()
    page.until(lambda: page.all("#brush"))


def paint_on(page, target):
    """Choose the setting that is painted."""
    choose = "const one = document.querySelector('#brush select'); one.value = arguments[0];"
    page.driver.execute_script(choose + "one.dispatchEvent(new Event('change'))", target)
    page.until(lambda: page.ask("brush.target") == target)


def value_at(picture, x, y):
    """Value of a picture over the square at a place [m]."""
    size = len(picture)
    return picture[int((0.5 - y / 0.2) * size), int((0.5 + x / 0.2) * size)]


@pytest.mark.slow
def test_length_is_painted_in_the_viewport_mirrored_and_undone(session, opened, folder):
    with served(session) as address:
        page = Page(opened(address), session)
        begin(page)
        paint_on(page, "length")
        page.find("#brush input[type=checkbox]").click()
        page.driver.execute_script("brush.radius = 0.02; viewer.camera.yaw = 0.2; viewer.redraw()")
        drag(page, (0.04, 0.03, 0.0), (0.06, 0.03, 0.0))
        page.until(lambda: "image" in str(given(session)["length"]))
        picture = read_image(folder / given(session)["length"]["image"])
        assert picture.shape == (512, 512)
        for side in (-1, 1):
            assert value_at(picture, side * 0.05, 0.03) < 0.02 and value_at(picture, side * 0.05, 0.055) == 1.0
            assert 0.3 < value_at(picture, side * 0.05, 0.03 + 0.013) < 0.9  # between hard core and border
        assert value_at(picture, 0.0, 0.03) == 1.0 and value_at(picture, 0.05, -0.03) == 1.0
        drag(page, (0.0, -0.05, 0.0), (0.0, -0.051, 0.0))
        page.until(lambda: given(session)["length"]["image"].endswith("_2.png"))
        second = read_image(folder / given(session)["length"]["image"])
        assert (second <= picture).all() and value_at(second, 0.0, -0.05) < 0.5 < value_at(picture, 0.0, -0.05)
        page.press("z", page.Keys.CONTROL)
        page.until(lambda: given(session)["length"]["image"].endswith("_1.png"))
        shown = "return brush.texels.values[arguments[0] * 512 + 256]"
        row = int((0.5 + 0.05 / 0.2) * 512)
        page.until(lambda: page.driver.execute_script(shown, row) == 255)
        page.driver.execute_script("app.answered++; brush.source = ''; brush.texels.values.fill(7)")
        page.ask("followPainting()")
        assert page.driver.execute_script(shown, row) == 7  # the graph is older than the last answer
        page.press("z", page.Keys.CONTROL)
        page.until(lambda: given(session)["length"] == 0.03)
        page.until(lambda: page.driver.execute_script(shown, row) == 255)
        paint_on(page, "density")
        value = "return brush.texels.values[arguments[0] * 512 + 256] / 255"
        assert page.driver.execute_script(value, row) == pytest.approx(0.25, abs=0.01)  # as the map that it reads
        page.press(page.Keys.ESCAPE)
        assert not page.all("#brush")
        session.edit("skin.bare", "true")
        assert not page.has_errors


@pytest.mark.slow
def test_hair_grows_where_the_density_is_painted(session, opened, folder):
    values = np.zeros((64, 64), np.uint8)
    values[:, 32:] = 255  # none at negative x
    stroke(session, "hair.density", values)
    with served(session) as address:
        page = Page(opened(address), session)
        do(page.driver, "selectNode('hair')")
        for target in ("length", "density"):
            page.ask("beginPainting(arguments[0])", target)
            page.ask("followPainting()")
            do(page.driver, "viewer.camera.yaw = viewer.camera.pitch = 0; viewer.redraw()")
            picture = pixels(page.driver)
            places = [page.driver.execute_script(PLACE, [side * 0.05, 0.08, 0.0]) for side in (-1, 1)]
            bald, grown = (picture[round(y), round(x)] for x, y in places)
            assert np.ptp(bald) < 0.6 * np.ptp(grown), "pale"


BUST = GRAPH.replace("make_skin", "make_bust").replace('{ map = "scalp" }', '{ map = "length" }')
RECORD = """window.dabs = []; brush.radius = 0.02; brush.falloff = 0; brush.value = 0;
const own = Texels.prototype.dab;
Texels.prototype.dab = function (cover, place, normal, brush) {
  dabs.push([place, normal]);
  own.call(this, cover, place, normal, brush);
};"""


@pytest.mark.kernels
@pytest.mark.slow
def test_a_stroke_on_the_bust_paints_all_skin_below_it_and_no_other(opened, folder):
    (folder / "bust.toml").write_text(BUST)
    shot = hairpipe.load(folder / "bust.toml", cache=folder / "cache")
    assert shot.run(jobs=1).ok
    mesh = shot.get("skin").mesh
    session = Session(shot)
    with served(session) as address:
        page = Page(opened(address), session)
        begin(page)
        assert "overlap" not in page.find("#note").text
        page.ask("beginPainting('length')")
        page.driver.execute_script(RECORD + "viewer.camera.yaw = 0.9; viewer.camera.pitch = 0; viewer.redraw()")
        cheek, shoulder = ((0.03, 0.27, 0.09), (0.07, 0.24, 0.02)), ((0.06, 0.17, 0.0), (0.13, 0.12, 0.0))
        drag(page, *cheek, *shoulder)
        page.until(lambda: "image" in str(given(session)["length"]))
        dabs = np.array(page.ask("dabs"))
        picture = read_image(folder / given(session)["length"]["image"])
    corners, shares = mesh.points[mesh.triangles], np.random.default_rng(1).dirichlet((1, 1, 1), (6, 1)).swapaxes(0, 1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    painted, kept = [], []
    for share in shares[0]:
        places, (u, v) = share @ corners, (share @ mesh.uv.astype(float)).T
        values = picture[((1 - v) * 512).astype(int), (u * 512).astype(int)]
        away = np.linalg.norm(places[:, None] - dabs[None, :, 0], axis=2)
        faces = (normals @ dabs[:, 1].T > 0.3) & (away < 0.02 - 0.004)  # by two texels
        painted.extend(values[faces.any(axis=1)])
        kept.extend(values[(away > 0.02 + 0.008).all(axis=1)])
    assert len(painted) > 3000 and max(painted) == 0.0
    assert len(kept) > 50_000 and min(kept) == 1.0


@pytest.mark.slow
def test_a_body_without_texture_coordinates_is_named(session, opened, folder):
    (folder / "painted.toml").write_text(GRAPH.replace('"make_skin"', '"make_skin"\nbare = true'))
    shot = hairpipe.load(folder / "painted.toml", cache=folder / "cache")
    assert shot.run(jobs=1).ok
    other = Session(shot)
    with served(other) as address:
        page = Page(opened(address), other)
        do(page.driver, "selectNode('hair')")
        page.find("#paint").click()
        page.until(lambda: "no texture coordinates" in page.find("#controls .said").text)
        assert not page.all("#brush")
