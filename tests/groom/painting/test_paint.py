"""Paint on a body, and how it varies."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hairpipe
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import read_image
from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Drag, Force, Thickness
from hairpipe.values import Mesh
from hairpipe.values.painting import Canvas, Paint, Painted, list_tiles, sample_image, sample_picture, values_of
from hairpipe.values.triangles import Sites, site_points


@pytest.fixture
def body(sheet, body_of):
    mesh = sheet(4, 4)
    return body_of(mesh, ramp=mesh.points[:, 0].copy())


@pytest.fixture
def sites(body):
    random = np.random.default_rng(0)
    return Sites(random.integers(0, len(body.mesh.triangles), 4000).astype(np.int32), random.dirichlet([1, 1, 1], 4000))


def ramp_picture(path: Path) -> np.ndarray:
    """Values that grow from 0 at the left edge to 1 at the right edge; pixel centres lie half a pixel inside."""
    return np.tile((np.arange(200) + 0.5) / 200, (3, 1))


def test_a_vertex_map_and_an_image_of_it_paint_the_same(body, sites):
    canvas = Canvas(body, ramp_picture, 0)
    x = site_points(body.mesh, sites)[:, 0]
    by_map = canvas.numbers(Painted(3.0, low=1.0, map="ramp"), "a", sites)
    by_image = canvas.numbers(Painted(3.0, low=1.0, image=Path("ramp.png")), "a", sites)
    assert np.allclose(by_map, 1 + 2 * x)
    inside = np.abs(x - 0.5) < 0.49
    assert np.allclose(by_map[inside], by_image[inside], atol=1e-6) and np.abs(by_map - by_image).max() < 0.01


def test_pictures_are_seen_upright_and_exactly_at_their_pixels():
    picture = np.random.default_rng(1).random((5, 7))
    row, column = (g.ravel() for g in np.meshgrid(np.arange(5), np.arange(7), indexing="ij"))
    uv = np.stack([(column + 0.5) / 7, 1 - (row + 0.5) / 5], axis=1)
    assert np.allclose(sample_picture(picture, uv), picture.ravel())
    assert np.allclose(
        sample_picture(picture, np.array([[0.0, 1.0], [1.0, 0.0], [5.0, -5.0]])), picture[[0, 4, 4], [0, 6, 6]]
    )
    middle = sample_picture(picture, np.array([[2.0 / 7, 1 - 3.0 / 5]]))
    assert np.allclose(middle, picture[2:4, 1:3].mean())


def test_without_paint_every_strand_has_the_value(body, sites):
    assert np.array_equal(Canvas(body, ramp_picture, 0).numbers(Painted(0.25), "length", sites), np.full(4000, 0.25))


def test_variation_is_uniform_and_relative(body, sites):
    values = Canvas(body, ramp_picture, 0).numbers(Painted(2.0, variation=0.3), "length", sites)
    assert 1.4 <= values.min() < 1.41 and 2.59 < values.max() <= 2.6
    assert abs(values.mean() - 2) < 0.02 and abs(values.std() - 0.6 / 3**0.5) < 0.01


def test_chance_differs_between_settings_and_seeds_only(body, sites):
    def draw(name, seed):
        return Canvas(body, ramp_picture, seed).numbers(Painted(1.0, variation=0.5), name, sites)

    assert np.array_equal(draw("length", 0), draw("length", 0))
    assert abs(np.corrcoef(draw("length", 0), draw("lift", 0))[0, 1]) < 0.05
    assert abs(np.corrcoef(draw("length", 0), draw("length", 1))[0, 1]) < 0.05


def test_invalid_paint_is_refused(body):
    canvas = Canvas(body, ramp_picture, 0)
    with pytest.raises(BadInput, match=r"curl.radius: the body has no map 'beard' \(its maps: 'ramp'\)"):
        canvas.coat(Paint(map="beard"), "curl.radius")
    with pytest.raises(BadInput, match="both a map and an image"):
        canvas.coat(Paint(map="ramp", image=Path("x.png")), "density")
    bare = Canvas(
        type(body)(Mesh(body.mesh.points, body.mesh.triangles), body.skeleton, body.joints, body.weights),
        ramp_picture,
        0,
    )
    with pytest.raises(BadInput, match="no texture coordinates"):
        bare.coat(Paint(image=Path("x.png")), "density")
    with pytest.raises(BadInput, match="its maps: none"):
        bare.coat(Paint(map="ramp"), "density")
    assert canvas.coat(Paint(), "density") is None


@pytest.fixture
def tiles(tmp_path):
    """Four tiles of one value each, and a file that is not a tile."""
    values = {"1001": 0.2, "1002": 0.4, "1011": 0.6, "1012": 0.8}
    for number in values:
        (tmp_path / f"skin.{number}.png").touch()
    (tmp_path / "skin.0999.png").touch()
    return tmp_path / "skin.<UDIM>.png", lambda path: np.full((2, 2), values[path.name.split(".")[1]])


def test_tiles_are_numbered_by_column_and_row(tiles):
    image, read = tiles
    uv = np.array([[0.3, 0.9], [1.3, 0.9], [0.3, 1.9], [1.3, 1.9], [2.0, 0.5], [1.5, 2.0], [2.0, 2.0], [1.0, 0.0]])
    assert sample_image(image, read, uv, "length").tolist() == [0.2, 0.4, 0.6, 0.8, 0.4, 0.8, 0.8, 0.4]
    assert sorted(list_tiles(image)) == ["1001", "1002", "1011", "1012"]


def test_each_tile_is_a_picture_of_its_own(tmp_path):
    for number in ("1001", "1002"):
        (tmp_path / f"a.{number}.png").touch()
    uv = np.array([[1.25, 0.5], [0.25, 0.5]])
    assert sample_image(tmp_path / "a.<UDIM>.png", ramp_picture, uv, "length").tolist() == pytest.approx([0.25, 0.25])


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ([2.5, 0.5], r"length: tile 1003 is missing, with 1 roots \(a file of that number, next to 1001\)"),
        ([-0.5, 0.5], r"texture coordinates \(-0.5, 0.5\) of a root are in no tile"),
        ([10.5, 0.5], r"in no tile \(0 to 10 along u"),
    ],
)
def test_a_tile_that_is_needed_and_missing_is_named(tiles, place, message):
    image, read = tiles
    with pytest.raises(BadInput, match=message):
        sample_image(image, read, np.array([[0.5, 0.5], place]), "length")
    with pytest.raises(BadInput, match=r"there are no tiles \(hair.1001.png\)"):
        sample_image(image.with_name("hair.<UDIM>.png"), read, np.array([[0.5, 0.5]]), "length")


def test_coordinates_outside_a_picture_are_warned_of():
    uv = np.array([[0.5, 0.5], [1.5, 0.5]])
    with pytest.warns(UserWarning, match=r"length: roots with texture coordinates outside 0..1 .*border of a.png"):
        assert sample_image(Path("a.png"), ramp_picture, uv, "length")[1] == pytest.approx(1.0, abs=0.01)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sample_image(Path("a.png"), ramp_picture, np.array([[0.0, 1.0], [1.0, 0.0]]), "length")


def test_all_tiles_key_a_result_and_a_path_without_tiles_is_refused(tiles, tmp_path):
    image, _ = tiles
    path = tmp_path / "shot.toml"
    text = 'schema = 1\nframes = [1, 2]\nfps = 24\n[head]\ntype = "make_bust"\n[groom]\ntype = "grow_groom"\n'
    path.write_text(f'{text}in.scalp = "head"\nlength = {{ value = 0.1, image = "{image.name}" }}\n')

    def keyed():
        graph = load_graph(path)
        return Resolver(graph, Store(tmp_path / "store"), graph.frames[:1]).settings["groom"]["length"]["image"]

    before = keyed()
    assert sorted(before) == ["1001", "1002", "1011", "1012"]
    image.with_name("skin.1011.png").write_text("other")
    assert {number for number, file in keyed().items() if file != before[number]} == {"1011"}
    path.write_text(path.read_text().replace("skin", "hair"))
    with pytest.raises(BadInput, match=r"shot.toml:9: \[groom\]: there are no tiles \(hair.1001.png\)"):
        load_graph(path)


GRAPH = """schema = 1
frames = [1, 2]
[tuft]
type = "make_strands"
[hair]
type = "simulate_hair"
in.groom = "tuft"
"""


@pytest.fixture
def groom():
    """Two strands with texture coordinates and a map with a value that is not a number."""
    line = np.linspace(0.0, 0.1, 5)[:, None] * [1.0, 0.0, 0.0]
    bare = unbound(np.array([line, line]), np.tile(np.eye(3, 4), (2, 1, 1)))
    return replace(bare, maps={"torn": np.array([1.0, np.nan])}, root_uv=np.full((2, 2), 0.5, np.float32))


@pytest.mark.parametrize(
    ("setting", "name", "message"),
    [
        (Drag(8.0, map="torn"), "air.drag", r"air.drag is nan 1/s: strands 1 .*0 to 1000 1/s"),
        (Drag(8.0, map="torn", image=Path("a.png")), "air.drag", r"both a map and an image.*one of the two"),
        (Force(2e-5, image=Path("missing.png")), "stiction.force", r"missing.png"),
        (Force(1.0, groups=(("tail", 2.0),)), "stiction.force", r"no group 'tail'"),
        (Thickness(5e-4, low=1e-7, profile=((0.0, 1.0), (1.0, 0.0))), "collisions.thickness", r"is 0 m: strands 0, 1"),
        (Thickness(5e-4, map="thick"), "collisions.thickness", r"no map or group 'thick'.*'torn'"),
    ],
)
def test_bad_variation_is_refused(groom, setting, name, message):
    with pytest.raises(BadInput, match=message):
        values_of(setting, groom, name, read_image)


def test_an_image_needs_texture_coordinates_of_roots(groom):
    bare = replace(groom, root_uv=np.zeros((2, 2), np.float32))
    with pytest.raises(BadInput, match=r"no texture coordinates for an image.*a map"):
        values_of(Drag(8.0, image=Path("a.png")), bare, "air.drag", read_image)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("air.drag = { image = 'none.png' }", r"none.png"),
        ("air.drag = { value = nan }", r"air.drag.value = NaN is not a finite number"),
        ("stiction.force = { value = 2.0 }", r"stiction.force.value = 2.0 is not allowed.*<= 1"),
        ("collisions.thickness = 0.0", r"collisions.thickness.value = 0.0 is not allowed.*1e-06"),
        ("collisions.thickness = { factor = 2.0 }", r"unknown setting 'collisions.thickness.factor'"),
    ],
)
def test_a_graph_with_a_bad_variation_is_refused_before_it_runs(tmp_path, line, message):
    path = tmp_path / "shot.toml"
    path.write_text(GRAPH + line)
    with pytest.raises(BadInput, match=message):
        hairpipe.load(path, cache=tmp_path / "cache").plan()
