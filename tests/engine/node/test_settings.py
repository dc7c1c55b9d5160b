"""Settings: checked, filled in, described."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import pytest

from hairpipe.engine import File, node
from hairpipe.engine.node.settings import build_settings, check_settings, fields_of, help_line, map_files
from hairpipe.errors import BadInput
from hairpipe.units import Fraction, Ge, Gt, Interval, Metres, Voxels


@dataclass(frozen=True)
class Curl:
    """A curl.

    radius  of the helix
    """

    radius: Annotated[Metres, Gt(0)] = 1
    axis: tuple[Metres, Metres, Metres] = (0, 0, 1)
    paint: Path | None = None

    def __post_init__(self):
        if self.axis == (0, 0, 0):
            raise ValueError("the axis of a curl has no direction")


@node(frames="once")
def grow(
    *,
    file: Path,
    count: Annotated[int, Ge(1)] = 3,
    mode: Literal["fast", "fine"] = "fast",
    voxel: Annotated[Metres, Interval(ge=2e-4, le=0.1)] = 0.005,
    band: Voxels = 8,
    share: Fraction = 0.5,
    sizes: tuple[Annotated[Metres, Gt(0)], ...] = (1,),
    curl: Curl | None = None,
    wave: Curl = Curl(radius=5),
    usual: Curl | None = Curl(radius=7),
    name: str = "x",
) -> File:
    """Grow.

    voxel  spacing of the samples
    """


TYPE = grow.__node__


def check(**given):
    return check_settings(TYPE, {"file": "a.obj"} | given, lambda names: "here")


def test_defaults_are_filled_in_and_floats_are_floats():
    plain = check(curl={})
    assert plain["band"] == 8.0 and type(plain["band"]) is float
    assert plain["curl"] == {"radius": 1.0, "axis": [0.0, 0.0, 1.0], "paint": None}
    assert plain["wave"]["radius"] == 5.0 and type(plain["wave"]["radius"]) is float
    assert check()["curl"] is None


def test_part_of_a_group_is_laid_over_its_default():
    assert check(wave={"paint": "p.png"})["wave"] == {"radius": 5.0, "axis": [0.0, 0.0, 1.0], "paint": "p.png"}
    assert check(curl={"paint": "p.png"})["curl"]["radius"] == 1.0


def test_false_leaves_an_optional_group_out_whatever_its_default_is():
    assert check()["usual"]["radius"] == 7.0
    assert check(usual=False, curl=False)["usual"] is None is check(curl=False)["curl"]
    assert build_settings(TYPE, check(usual=False))["usual"] is None
    with pytest.raises(BadInput, match="wave = false is not allowed"):
        check(wave=False)


def test_arguments_are_built_from_plain_values():
    built = build_settings(TYPE, check(curl={"radius": 2, "paint": "p.png"}, sizes=[1, 2.5]))
    assert built["curl"] == Curl(2.0, (0.0, 0.0, 1.0), Path("p.png"))
    assert built["file"] == Path("a.obj") and built["sizes"] == (1.0, 2.5)
    assert built["wave"] == Curl(5.0, (0.0, 0.0, 1.0))


def test_files_are_found_in_groups_too():
    found = map_files(fields_of(TYPE), check(curl={"paint": "p.png"}), lambda name, file: f"{name}:{file}")
    assert found["file"] == "file:a.obj" and found["wave"]["paint"] is None
    assert found["curl"]["paint"] == "curl.paint:p.png"


@pytest.mark.parametrize(
    ("given", "reported"),
    [
        ({"cuont": 3}, "unknown setting 'cuont' (did you mean 'count'?)"),
        ({"count": 0}, "count = 0 is not allowed (a whole number, >= 1, default 3)"),
        ({"count": 2.0}, "count = 2.0 is not allowed"),
        ({"count": True}, "count = true is not allowed"),
        ({"voxel": True}, "voxel = true is not allowed"),
        ({"voxel": 5}, "voxel = 5 is not allowed (a number in m, >= 0.0002, <= 0.1, default 0.005)"),
        ({"voxel": float("nan")}, "voxel = NaN is not a finite number"),
        ({"voxel": [float("inf")]}, "voxel = [Infinity] is not a finite number"),
        ({"voxel": 10**400}, "is not allowed (a number in m"),
        ({"share": 1.5}, "share = 1.5 is not allowed (a number, >= 0, <= 1, default 0.5)"),
        ({"mode": "slow"}, "mode = \"slow\" is not allowed (one of 'fast', 'fine'"),
        ({"name": 3}, "name = 3 is not allowed (a text"),
        ({"file": 3}, "file = 3 is not allowed (a file)"),
        ({"sizes": 3}, "sizes = 3 is not allowed (a list, any number of: a number in m"),
        ({"sizes": [1, -1]}, "sizes = -1 is not allowed"),
        ({"curl": 3}, "curl = 3 is not allowed (a group: radius, axis, paint)"),
        ({"curl": {"raduis": 3}}, "unknown setting 'curl.raduis' (did you mean 'radius'?)"),
        ({"curl": {"radius": 0}}, "curl.radius = 0 is not allowed (a number in m, > 0"),
        ({"curl": {"axis": [1, 2]}}, "curl.axis = [1, 2] is not allowed"),
        ({"curl": {"axis": [0, 0, 0]}}, "the axis of a curl has no direction"),
    ],
)
def test_invalid_settings_are_reported_with_valid_ones(given, reported):
    with pytest.raises(BadInput) as caught:
        check(**given)
    assert str(caught.value).startswith("here: ") and reported in str(caught.value), str(caught.value)


def test_description_contains_kind_unit_range_default_and_help():
    fields = {field.name: field for field in fields_of(TYPE)}
    voxel = fields["voxel"]
    assert (voxel.unit, voxel.range, voxel.help) == ("m", ">= 0.0002, <= 0.1", "spacing of the samples")
    assert [inner.name for inner in fields["curl"].group] == ["radius", "axis", "paint"]
    assert fields["curl"].optional and fields["curl"].group[0].help == "of the helix"
    assert fields["file"].required
    with pytest.raises(BadInput, match="setting 'file' is missing"):
        check_settings(TYPE, {}, lambda names: "here")


def test_help_continues_over_lines_that_begin_below_it():
    document = """What.

    first    one, and
             two
    second   three
    third    four

             five
    """
    assert [help_line(document, name) for name in ("first", "second", "third", "irs")] == [
        "one, and two", "three", "four", "",
    ]  # fmt: skip


def test_settings_of_other_kinds_are_refused():
    @node(frames="once")
    def odd(*, table: dict[str, int]) -> File:
        """Odd."""

    @node(frames="once")
    def files(*, pictures: tuple[Path, ...]) -> File:
        """Files, of which a key would hold the names alone."""

    for declared in (odd, files):
        with pytest.raises(TypeError, match="neither a value nor a frozen dataclass"):
            fields_of(declared.__node__)


def test_tuples_in_tuples_are_tuples_too():
    @node(frames="once")
    def pairs(
        *, given: tuple[tuple[str, float], ...] = (("a", 1.0),), axes: tuple[tuple[Metres, Metres], int] = ((0, 1), 2)
    ) -> File:
        """Pairs."""

    plain = check_settings(pairs.__node__, {"given": [["b", 2], ["c", 3]]}, lambda names: "here")
    built = build_settings(pairs.__node__, plain)
    assert built == {"given": (("b", 2.0), ("c", 3.0)), "axes": ((0.0, 1.0), 2)}
    assert build_settings(pairs.__node__, check_settings(pairs.__node__, {}, str))["given"] == (("a", 1.0),)
