"""The cases beside the checkout, `../shared/cases`: troubles that people reported of other tools, as small inputs.

What is right is said in the README of each. They are not shipped: where they are absent, these tests are skipped.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import hairpipe
from hairpipe.levelset.sample import distance, field_of

CASES = Path(__file__).resolve().parents[2] / "shared" / "cases"
BIND = Path(sys.executable).parent
pytestmark = [
    pytest.mark.kernels,
    pytest.mark.skipif(not CASES.is_dir(), reason="no ../shared/cases beside the checkout"),
]


class Result(NamedTuple):
    """What became of a case: the shot after its run, and all warnings as one text."""

    shot: hairpipe.Shot
    warnings: str


class Case(NamedTuple):
    """A graph of a folder of cases, and what is right.

    graph    file, in the folder of the cases
    to       node that is computed, with what it depends on
    refused  pattern of the one line by which it is refused; None where it is computed
    warned   pattern of a warning that comes; None where none has to
    silent   pattern of warnings that may not come
    right    checks the results
    """

    graph: str
    to: str
    refused: str | None = None
    warned: str | None = None
    silent: str | None = None
    right: Callable[[Result], None] = lambda result: None


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy of all cases, which are read-only, with a store of their own."""
    folder = tmp_path_factory.mktemp("cases")
    for source in sorted(CASES.rglob("*")):
        if source.is_file():
            (folder / source.relative_to(CASES)).parent.mkdir(exist_ok=True)
            shutil.copyfile(source, folder / source.relative_to(CASES))
    cut = folder / "teleport_cut" / "graph.toml"  # written when cuts were a setting of the hair
    cut.write_text("cuts = [1013]\n" + cut.read_text().replace(", cuts = [1013]", ""))
    yield folder


def compute(folder: Path, graph: str, to: str, settings: dict | None = None) -> Result:
    """Compute a node of a graph; the first failure is raised."""
    shot = hairpipe.load(str(folder / graph), settings or {}, cache=folder / "cache")
    done = shot.run(to=to, jobs=1)
    for failure in done.failures:
        raise hairpipe.BadInput(failure.message)
    return Result(done.shot, "\n".join(done.warning_lines()))


def turn_of_head(shot: hairpipe.Shot) -> tuple[np.ndarray, float]:
    """Axis and angle [deg] of the largest turn of the head from its first frame."""
    head = shot.get("head").skeleton.names.index("head")
    first, last = shot.graph.frames
    turns = [shot.get(f"motion@{frame}").transforms[head, :3, :3] for frame in range(first, last + 1)]
    turn = max((turn @ turns[0].T for turn in turns), key=lambda turn: -np.trace(turn))
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return axis / np.linalg.norm(axis), float(np.degrees(np.arccos((np.trace(turn) - 1.0) / 2.0)))


def shakes(result: Result) -> None:
    """The head turns about the vertical."""
    axis, angle = turn_of_head(result.shot)
    assert angle > 10.0 and abs(axis[1]) > 0.9


def begins_at_full_speed(result: Result) -> None:
    """The first frame is as fast as the second."""
    first, second = (np.linalg.norm(result.shot.get(f"body@{f}").velocities, axis=1).mean() for f in (1001, 1002))
    assert first == pytest.approx(second, rel=0.05) and first > 1.0


def is_still_at_the_cut(result: Result) -> None:
    """Neither body nor hair has a speed across the cut."""
    for frame in (1012, 1013):
        for node in ("cut.strands", "body"):
            assert np.abs(result.shot.get(f"{node}@{frame}").velocities).max() < 1.0


def is_followed_or_named(result: Result) -> None:
    """The head goes where its channels carry it, or a warning names them."""
    first, last = (result.shot.get(f"motion@{f}").transforms for f in (1001, 1012))
    neck, head = (result.shot.get("head").skeleton.names.index(name) for name in ("neck", "head"))
    apart = [np.linalg.norm(t[head, :3, 3] - t[neck, :3, 3]) for t in (first, last)]
    assert abs(apart[1] - apart[0]) > 0.005 or re.search("translation|position", result.warnings)


def has(strands: int, widths: bool = False) -> Callable[[Result], None]:
    """There are so many strands, with widths that vary where they should."""

    def check(result: Result) -> None:
        groom = result.shot.get("groom")
        assert len(groom.ids) == strands
        assert not widths or groom.widths.min() < groom.widths.max()

    return check


def is_solid(result: Result) -> None:
    """The sign of the distance is that of the whole ball: negative within, positive without."""
    surface = field_of(result.shot.get("surface@1001"))
    body = result.shot.get("body").mesh.points
    middle, radius = body.mean(axis=0), np.linalg.norm(body - body.mean(axis=0), axis=1).max()
    for way in np.concatenate([np.eye(3), -np.eye(3)]):
        assert [distance(surface, *(middle + share * radius * way)) < 0.0 for share in (0.3, 0.9, 1.1)] == [1, 1, 0]


USD = [
    Case("tip_first/graph.toml", "groom", refused="other end"),
    Case("double_transform/graph.toml", "groom", refused="one vector"),
    Case("hair_sampled_later_than_body/graph.toml", "groom", right=has(20)),
    Case("nurbs_curves/graph.toml", "groom", silent=".", right=has(20)),
    Case("one_point_curve/graph.toml", "groom", warned="short|point", right=has(20)),
    Case("taper_to_zero_width/graph.toml", "groom", silent="widths", right=has(20, widths=True)),
    Case("varying_widths/graph.toml", "groom", silent="widths", right=has(20, widths=True)),
    Case("mirrored_parent/graph.toml", "groom", silent=".", right=has(20)),
    Case("rig_scaled_001/graph.toml", "groom", silent=".", right=has(20)),
    *(
        Case(f"foreign_grooms/{kind}.toml", "groom", silent=".", right=has(5))
        for kind in ("hair", "data", "ply", "obj")
    ),
]
CLIPS = [
    Case("plain/graph.toml", "body", right=shakes),
    Case("z_up_no_head/graph.toml", "body", right=shakes),
    Case("vroid_names/graph.toml", "body", right=shakes),
    Case("starts_moving/graph.toml", "body", right=begins_at_full_speed),
    Case("stretched_head/graph.toml", "body", right=is_followed_or_named),
    Case("teleport_cut/graph.toml", "cut", right=is_still_at_the_cut),
]
TIMES = [
    Case("alembic_25_in_24/body.toml", "body", warned=r"1/25 s apart.*frames 960.96 to 969.6.*speed = 0.96"),
    Case("alembic_25_in_24/body_24.toml", "body", silent="."),
    Case("usd_25_in_24/shot.toml", "body", warned=r"1/25 s apart.*1/24 s: .*speed = 0.96"),
    Case("mixed_layer_rates/shot.toml", "body", warned=r"anim_25.usda has 25 .*shot.usda 24, as it states none"),
]
STAGES = [
    Case("uv_count/shot.toml", "body", warned=r"primvars:st has \d+ elements, not \d+ for faceVarying"),
    Case("missing_reference/collider.toml", "all", refused=r"garment_v012\.usda does not exist"),
    Case("missing_reference/groom.toml", "groom", silent=".", right=has(48)),
    Case("missing_reference/body.toml", "head", silent="."),
]
SURFACES = [
    *(
        Case(f"windows_paths/{name}.toml", "head", refused=right)
        for name, right in {
            "backslash_h": r"is an escape: write / or",
            "backslash_t": r"is an escape: write / or",
            "literal": r"/ separates folders \('assets/turn.usda'\)",
            "drive": r"is on a drive of Windows",
        }.items()
    ),
    Case("growing_character/shot.toml", "hair", warned="has grown by 10 % since the first frame, .*keeps its length"),
    Case("thin_ear/graph.toml", "surface", warned="does not stop hair"),
    Case("mixed_winding_hollow/graph.toml", "surface", right=is_solid),
]


@pytest.mark.parametrize(
    "case", [*USD, *CLIPS, *TIMES, *STAGES, *SURFACES], ids=lambda case: case.graph.removesuffix("/graph.toml")
)
def test_the_outcome_is_right(case, folder):
    if case.refused is not None:
        with pytest.raises(hairpipe.BadInput, match=case.refused) as fault:
            compute(folder, case.graph, case.to)
        assert "\n" not in str(fault.value).strip()
        return
    result = compute(folder, case.graph, case.to)
    assert case.warned is None or re.search(case.warned, result.warnings, re.DOTALL)
    assert case.silent is None or not re.search(case.silent, result.warnings)
    case.right(result)


@pytest.mark.parametrize("file", ["flip.obj", "mixed.obj", "nested.obj"])
def test_balls_of_other_windings_are_solid(file, folder):
    settings = {"body.file": str(folder / "mixed_winding_hollow" / file)}
    is_solid(compute(folder, "mixed_winding_hollow/graph.toml", "surface", settings))


def test_a_whole_body_follows_joints_with_the_names_of_asf(folder, shared):
    """The motion of the clip is that of the plain one."""
    made = shared / "body_makehuman"
    settings = {
        "head.type": "load_body",
        "head.file": str(made / "base.obj"),
        "head.group": "body",
        "head.unit": 0.1,
        "head.skeleton": str(made / "default.mhskel"),
        "head.weights": str(made / "default_weights.mhw"),
    }
    shots = [compute(folder, f"{case}/graph.toml", "motion", settings).shot for case in ("amc_names", "plain")]
    for frame in (1001, 1012):
        named, plain = (shot.get(f"motion@{frame}").transforms for shot in shots)
        np.testing.assert_allclose(named, plain, atol=1e-6)


def shell(folder: Path, words: str) -> str:
    """Carry out a shell command in a folder, and give what it printed."""
    variables = os.environ | {"HP": str(BIND / "hairpipe")}
    done = subprocess.run(words, shell=True, cwd=folder, env=variables, capture_output=True, text=True)
    assert "Traceback" not in done.stderr, done.stderr
    return done.stdout


def counts(text: str) -> list[int]:
    """List the results that runs have computed, as they say."""
    return [int(number) for number in re.findall(r"^(\d+) results? computed", text, re.MULTILINE)]


def test_a_renamed_project_computes_nothing(folder):
    place = folder / "moved_project"
    shutil.copyfile(folder / "plain" / "clip.bvh", place / "clip.bvh")
    (place / "kept").mkdir()
    for name in ("g.toml", "clip.bvh"):
        shutil.copyfile(place / name, place / "kept" / name)
    found = counts(shell(place, "sh try.sh kept"))
    assert found[0] > 0 and found[1:] == [0, 0]


def test_an_edit_that_keeps_size_and_time_is_noticed(folder):
    place = folder / "same_size_same_mtime"
    shutil.copyfile(folder / "plain" / "clip.bvh", place / "clip.bvh")
    first, second = counts(shell(place, "sh try.sh"))
    assert 0 < second < first


def test_replaced_inputs_are_not_stored_under_another_key(folder):
    """Of the groom that the plan has found, nothing but its own value may be in the store."""
    place = folder / "changed_during_run"
    scene = (folder / "rig_scaled_001" / "scene.usda").read_text()
    other = (folder / "taper_to_zero_width" / "scene.usda").read_text()
    for name, text in (("b.usda", scene), ("A.usda", scene), ("B.usda", other), ("h.usda", scene)):
        (place / name).write_text(text)
    truth = compute(folder, "changed_during_run/t.toml", "groom").shot.get("groom")
    script = (place / "try.sh").read_text()
    delays = script.partition("for d in ")[2].partition(";")[0]

    def replace_after(delay: str) -> hairpipe.Shot:
        copy = shutil.copytree(place, folder / f"changed_after_{delay}")
        (copy / "try.sh").write_text(script.replace(delays, delay))
        shell(copy, "sh try.sh A.usda B.usda")
        return hairpipe.load(str(copy / "t.toml"), cache=copy / "tc")

    with ThreadPoolExecutor() as pool:  # they sleep most of the time
        shots = list(pool.map(replace_after, delays.split()))
    assert len(shots) > 1
    for shot in shots:
        if all(entry.status == "cached" for entry in shot.plan(to="groom")):
            assert np.array_equal(shot.get("groom").points, truth.points)


def test_the_swing_on_a_ball_runs(folder):
    place = folder / "swing_on_ball"
    subprocess.run([sys.executable, "make.py", "100"], cwd=place, check=True)
    shot = hairpipe.load(str(place / "swing.toml"), cache=folder / "cache")
    assert not shot.run("1001-1002", to="hair", jobs=1).failures
