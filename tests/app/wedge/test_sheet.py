"""The contact sheet of a wedge: which picture is where."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import hairpipe
from hairpipe.app.wedge import layout, write_sheet
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import GAP

NODE = '''"""A picture of a number."""

from numeral import Numeral

from hairpipe.engine import File, Workspace, node


@node(frames="each")
def paint_number(number: Numeral, workspace: Workspace) -> File:
    """Paint a number as a shade of red."""
    from PIL import Image

    path = workspace / "picture.png"
    Image.new("RGB", (64, 48), (round(number.value), 0, 0)).save(path)
    return File(path)
'''
WEDGE = """
[picture]
type = "paint_number"
in.number = "move"
[wedge.steps]
axes.move.step = [10.0, 20.0]
axes.seed.value = [1, 2, 3]
where = [["step", "<", 15.0], ["value", "!=", 2]]
show = ["picture"]
[wedge.joint]
joint = true
axes.move.step = [1.0, 2.0, 3.0, 4.0, 5.0]
axes.seed.value = [1, 2, 3, 4, 5]
show = ["list"]
[wedge.bare]
axes.move.step = [1.0]
"""
SIZE = (64, 48)


@pytest.fixture
def graph(shot):
    Path("nodes/paint_number.py").write_text(NODE)
    shot.write_text(shot.read_text() + WEDGE)
    return hairpipe.load(shot)


def shades(path):
    """Return the red in the lower middle of every place, in rows."""
    picture = np.asarray(Image.open(path))
    return picture[SIZE[1] - 8 :: SIZE[1] + GAP, SIZE[0] // 2 :: SIZE[0] + GAP, 0].tolist()


def test_each_column_is_a_value_of_the_last_axis(graph, tmp_path):
    table = graph.tables["wedge"]["steps"] | {"where": []}
    wedge = graph.edited(graph.tables | {"wedge": {"all": table}}).wedge("all")
    wedge.run("1-3", to="picture", jobs=1)
    write_sheet(tmp_path / "sheet.png", wedge, 3)
    assert shades(tmp_path / "sheet.png") == [[31, 32, 33], [61, 62, 63]]


def test_places_without_a_variant_or_a_picture_are_empty(graph, tmp_path):
    wedge = graph.wedge("steps")
    names = ["step=10,value=1", None, "step=10,value=3", None, None, None]
    assert [variant and variant.name for variant in layout(wedge)[0]] == names
    hairpipe.load(graph.path, {"move.step": 10.0, "seed.value": 3}).run("2", to="picture", jobs=1)
    write_sheet(tmp_path / "sheet.png", wedge, 2)
    ((first, second, third), below) = shades(tmp_path / "sheet.png")
    assert third == 23 and first == second == below[0] == below[2]


def test_joint_variants_fill_a_square(graph):
    places, columns = layout(graph.wedge("joint"))
    assert columns == 3 and [variant.settings["seed.value"] for variant in places if variant] == [1, 2, 3, 4, 5]


def test_a_node_without_pictures_is_bad_input(graph, tmp_path):
    for name, node, message in (
        ("bare", None, "no picture is shown"),
        ("steps", "pictur", r"'pictur' is not shown \(did you mean 'picture'\?\)"),
        ("steps", None, "no 'picture' has been computed at frame 6 .*--wedge steps"),
    ):
        with pytest.raises(BadInput, match=message):
            write_sheet(tmp_path / "sheet.png", graph.wedge(name), node=node)
    graph.wedge("joint").run(jobs=1, to="list")
    with pytest.raises(BadInput, match="cannot be read as a picture"):
        write_sheet(tmp_path / "sheet.png", graph.wedge("joint"))
