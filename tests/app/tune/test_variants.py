"""Variants of a graph in one, and what can be left out of it."""

import re
import tomllib
from collections import Counter
from copy import deepcopy
from pathlib import Path

import pytest

from hairpipe.app import tune
from hairpipe.app.tune.report import changed_tables, write_toml
from hairpipe.app.tune.sampling import Sample
from hairpipe.app.tune.simplifications import scaled_steps, simplifications
from hairpipe.app.tune.study import merged_variants, sampled, simplified, with_node
from hairpipe.engine.file.load import load_graph

SCENE = """schema = 1
frames = [1, 30]
fps = 24
[head]
type = "make_bust"
[body]
type = "pose_body"
in.rest = "head"
[surface]
type = "bake_levelset"
in.body = "body"
[groom]
type = "grow_groom"
in.scalp = "head"
segments = 20
[hair]
type = "simulate_hair"
in = { groom = "groom", body = "body", surface = ["surface"] }
[hair.collisions]
thickness = 2e-4
[hair.stiction]
"""


@pytest.fixture
def scene(tmp_path) -> Path:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


def parts_by_axis(path: Path) -> dict[str, list]:
    parts = simplifications(load_graph(path), "hair")
    return {axis: [p for p in parts if p.axis == axis] for axis in {p.axis: None for p in parts}}


def loaded(path: Path, tables: dict):
    """Write tables of nodes as a graph file, and load it."""
    path.write_text("schema = 1\nframes = [1, 30]\nfps = 24\n" + write_toml(changed_tables({}, tables), ""))
    return load_graph(path)


def test_each_axis_leaves_out_more_and_more_and_every_variant_is_a_graph(scene):
    axes = parts_by_axis(scene)
    listed = "model segments steps voxels collisions stiction pairs locks keys particles"
    assert list(axes) == listed.split()
    for parts in axes.values():
        assert [part.level for part in parts] == list(range(1, len(parts) + 1))
        for part in parts:
            scene.write_text(SCENE)
            before = load_graph(scene).nodes
            changed = loaded(scene, simplified(tomllib.loads(SCENE), "hair", [part])).nodes
            assert len(changed) > len(before) or {n for n in before if changed[n].settings != before[n].settings}


@pytest.mark.parametrize(
    ("model", "others"), [("network", ["rod", "chain"]), ("rod", ["network", "chain"]), ("chain", [])]
)
def test_every_other_strand_model_is_tried_that_has_no_more_in_it(scene, model, others):
    scene.write_text(SCENE.replace("[hair.collisions]", f'model = "{model}"\n[hair.collisions]'))
    parts = parts_by_axis(scene).get("model", [])
    assert [part.puts for part in parts] == [(("hair.model", other),) for other in others]


def test_no_model_is_named_in_tune_itself():
    """A model lists its own simplifications: what tune itself knows holds for any."""
    text = "".join(path.read_text() for path in Path(tune.__file__).parent.glob("*.py"))
    assert not re.findall(r"simulate_\w+|\bnetwork\b|\brod\b|\bchain\b", text)


def test_absent_physics_is_not_simplified(scene):
    scene.write_text(SCENE[: SCENE.index("[hair.collisions]")] + 'model = "chain"\nsteps.longest = 0.05\n')
    assert list(parts_by_axis(scene)) == ["segments", "voxels", "particles"]


SURFACE, ENDS = 'surface = ["surface"] }', 'surface = ["surface"], ends = "hand" }'


@pytest.mark.parametrize(
    ("old", "new", "axis"),
    [
        ("thickness = 2e-4", 'solver = "sweep"', "locks"),
        ("thickness = 2e-4", "thickness = 3e-4\n[hair.volume]", "locks"),
        ("thickness = 2e-4", "thickness = 3e-4\n[hair.locks]", "locks"),
        (SURFACE, ENDS, "particles"),
        ("[hair.collisions]", "gravity = 0.0\n[hair.collisions]", "particles"),
    ],
)
def test_hair_that_cannot_be_in_locks_or_particles_is_not_put_into_them(scene, old, new, axis):
    """It is in locks, has a volume, ends of a hand, no weight."""
    assert axis in parts_by_axis(scene)
    scene.write_text(SCENE.replace(old, new) + '[hand]\ntype = "drive_ends"\nin.groom = "groom"\n')
    assert axis not in parts_by_axis(scene)


def test_single_precision_is_tried_where_double_was_requested(scene):
    scene.write_text(SCENE.replace('type = "simulate_hair"\n', 'type = "simulate_hair"\nprecision = "double"\n'))
    (part,) = parts_by_axis(scene)["precision"]
    assert part.puts == (("hair.precision", "automatic"),)


def test_variants_share_what_they_have_in_common(scene):
    tables = tomllib.loads(SCENE)
    before = deepcopy(tables)
    parts = parts_by_axis(scene)
    coarse, dry = (simplified(tables, "hair", [parts[axis][0]]) for axis in ("voxels", "stiction"))
    merged, names = merged_variants({"full": tables, "coarse": coarse, "dry": dry}, ["hair"])
    kinds = Counter(table["type"] for table in merged.values() if isinstance(table, dict))
    assert kinds == {"make_bust": 1, "pose_body": 1, "grow_groom": 1, "bake_levelset": 2, "simulate_hair": 3}
    assert len({name for (name,) in names.values()}) == 3 and tables == before


def test_consumers_use_the_inserted_node(scene):
    tables = with_node(tomllib.loads(SCENE), "few", {"type": "sample_groom", "in": {"groom": "groom"}}, instead="groom")
    assert tables["hair"]["in"]["groom"] == "few" and tables["few"]["in"]["groom"] == "groom"


def test_a_fragment_says_the_same_as_the_tables_and_no_more(scene):
    tables = tomllib.loads(SCENE)
    parts = [found[-1] for axis, found in parts_by_axis(scene).items() if axis not in ("particles", "locks")]
    after = simplified(tables, "hair", parts)
    fragment = tomllib.loads(write_toml(changed_tables(tables, after), "why\n\nand how"))
    assert fragment == {name: after[name] for name in ("surface", "groom", "hair", "hair-shown", "hair-keys")}
    assert "collisions" not in fragment["hair"] and fragment["groom"]["segments"] == 7


def test_key_hairs_are_simulated_and_who_took_hair_takes_all_of_it(scene):
    """The picture, which took the simulation, takes what is interpolated; the cache of states stays with the keys."""
    for edge in ("hair", "hair.strands"):
        scene.write_text(SCENE + f'[picture]\ntype = "preview"\nin = {{ hair = "{edge}", body = "body" }}\n')
        part = parts_by_axis(scene)["keys"][0]
        after = simplified(tomllib.loads(scene.read_text()), "hair", [part])
        assert after["picture"]["in"]["hair"] == "hair-shown"
        edges = {"hair": "hair", "keys": "hair-keys", "groom": "groom", "body": "body", "surface": ["surface"]}
        assert after["hair-shown"]["in"] == edges
        assert after["hair"]["in"]["groom"] == "hair-keys" and after["hair-keys"]["every"] == part.keys == 4
        loaded(scene, after)


def test_particles_take_the_place_of_strands_and_carry_them_under_the_same_name(scene):
    """With what both models have in common; the sample of strands that is tuned is carried by those of all hair."""
    reported = "material.diameter = 5e-5\ncontact.friction = 0.1\nwind.velocity = [1.0, 0.0, 0.0]\n"
    picture = '[picture]\ntype = "preview"\nin = { hair = "hair.strands", body = "body" }\n'
    scene.write_text(SCENE.replace("[hair.collisions]", reported + "[hair.collisions]") + picture)
    part = parts_by_axis(scene)["particles"][1]
    tables = tomllib.loads(scene.read_text())
    after = simplified(sampled(tables, "hair", Sample(8, 4, 0, 1, 2, 3)), "hair", [part])
    assert after["picture"]["in"]["hair"] == "hair"
    assert after["hair"]["type"] == "carry_strands" and after["hair"]["in"]["groom"] == "tune-sample"
    assert after["hair-particles"]["in"] == {"groom": "groom"} and after["hair-particles"]["particles"] == 500
    cloud = after["hair-cloud"]
    assert cloud["in"] == {"particles": "hair-particles", "body": "body", "surface": ["surface"]}
    assert (cloud["contact"], cloud["fibre"]) == ({"friction": 0.1}, {"diameter": 5e-5})
    assert cloud["wind"] == {"velocity": [1.0, 0.0, 0.0]} and cloud["interaction"] == {} and "sag_free" not in cloud
    loaded(scene, after)


def test_a_volume_takes_the_place_of_pairs(scene):
    (part,) = parts_by_axis(scene)["pairs"]
    after = simplified(tomllib.loads(SCENE), "hair", [part])["hair"]
    assert after["volume"] == {"cell": 0.006} and "stiction" not in after and "collisions" not in after


def test_any_text_of_a_graph_can_be_written(scene):
    texts = {"hair": {"type": "x", "file": '\U0001f9b1/é\x7f\t"\\', "\U0001f9b1\x7f": {"a.b": "ü"}}}
    assert tomllib.loads(write_toml(texts, "why")) == texts


def test_every_groom_behind_the_hair_gets_fewer_segments(scene):
    joined = SCENE.replace('in = { groom = "groom"', 'in = { groom = "both"')
    joined += '[beard]\ntype = "grow_groom"\nin.scalp = "head"\nsegments = 8\n'
    joined += '[both]\ntype = "join_grooms"\nin.grooms = ["groom", "beard"]\n'
    scene.write_text(joined)
    parts = parts_by_axis(scene)["segments"]
    segments = [{"groom.segments": first, "beard.segments": other} for first, other in ((15, 6), (10, 4), (7, 3))]
    assert [dict(part.puts) for part in parts] == segments
    assert parts[1].text == "10, 4 segments, not 20, 8"


def test_segments_by_length_or_default_get_longer(scene):
    for reported, before in (("segment_length = 0.02", 0.02), ("", 0.005)):
        scene.write_text(SCENE.replace("segments = 20", reported))
        parts = parts_by_axis(scene)["segments"]
        lengths = [dict(part.puts)["groom.segment_length"] for part in parts]
        assert lengths == pytest.approx([before / 0.75, before / 0.5, before / 0.33], rel=1e-5)
        assert parts[1].text == f"segments of {2 * before:g} m"


def test_bounds_of_steps_are_scaled_within_range(scene):
    scene.write_text(SCENE.replace("[hair.stiction]", "[hair.stiction]\n[hair.steps]\ncourant = 4.0\ntravel = 1e3"))
    node = load_graph(scene).nodes["hair"]
    assert dict(scaled_steps(node, 2.0)) == {
        "hair.steps.longest": pytest.approx(1 / 120, rel=1e-5),
        "hair.steps.root": 0.02,
        "hair.steps.travel": 1e3,
        "hair.steps.courant": 8.0,
    }


def test_ends_of_key_strands_are_those_of_the_thinned_groom(scene):
    """A hand moves the roots: key strands get ends of their own, and the others are interpolated with those of all."""
    hand = '[hand]\ntype = "drive_ends"\nin.groom = "groom"\nat = 1\n'
    scene.write_text(SCENE.replace(SURFACE, ENDS) + hand)
    tables = simplified(tomllib.loads(scene.read_text()), "hair", [parts_by_axis(scene)["keys"][0]])
    inputs = {"groom": "hair-keys", "body": "body", "surface": ["surface"], "ends": "hand-keys"}
    assert tables["hair"]["in"] == inputs
    assert tables["hand-keys"] == {"type": "drive_ends", "in": {"groom": "hair-keys"}, "at": 1}
    assert tables["hair-shown"]["in"]["ends"] == "hand" and tables["hand"]["in"] == {"groom": "groom"}
