"""From a graph file to settings: a few hairs that fall."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from hairpipe.app.api.shot import Shot, load
from hairpipe.app.cli.commands.tune import runner
from hairpipe.app.cli.entry import commands
from hairpipe.app.cli.options import Engine
from hairpipe.app.tune.measured import Results, Tolerance
from hairpipe.app.tune.sampling import choose_sample
from hairpipe.app.tune.simplifications import simplifications
from hairpipe.app.tune.study import Request, Study
from hairpipe.app.tune.tuning import CHECKS, Scene, look_at, sample_of
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.events import Failure, Outcome
from hairpipe.errors import BadInput

pytestmark = [pytest.mark.kernels, pytest.mark.usefixtures("kept_workers")]

SCENE = """schema = 1
frames = [1, 8]
fps = 24
[groom]
type = "make_strands"
strands = 8
length = 0.1
segments = 5
spacing = [0.0, 0.0, 0.02]
[hair]
type = "simulate_hair"
in.groom = "groom"
model = "chain"
steps = { longest = 0.0208333333 }
[hair.stiction]
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("tune") / "scene.toml"
    path.write_text(SCENE)
    return path


ALONE = Engine(jobs=1, scans=1, scheduler=None, insecure=False)


def opened(path: Path) -> Shot:
    return load(path, cache=path.parent / "cache")


def request(path: Path, **settings) -> Request:
    return Request(
        opened(path), "hair", **{"tolerance": Tolerance(0.02, "m"), "run": runner(ALONE, quiet=True), **settings}
    )


def call(scene: Path, *arguments: str) -> Result:
    """Call the command."""
    command = ["tune", str(scene), "--node", "hair", "--json", "--cache", str(scene.parent / "cache"), *arguments]
    return CliRunner().invoke(commands, command, prog_name="hairpipe")


def tune(scene: Path, *arguments: str, expected: int = 0) -> tuple[dict, str]:
    """Call the command, and give its document and what it said besides."""
    result = call(scene, *arguments)
    assert result.exit_code == expected, result.output
    return json.loads(result.stdout), result.stderr


def written(scene: Path, name: str, text: str) -> Path:
    """Write another graph next to the scene."""
    path = scene.parent / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_tuning_measures_chooses_verifies_and_caches(scene):
    found, reported = tune(scene, "--tolerance", "20mm", "-o", str(scene.parent / "tuned.toml"))
    assert "measuring: no stiction" in reported
    chosen = found["chosen"]
    assert chosen["bound"] <= 0.02 and found["kept"]
    assert chosen["seconds"] <= found["full"]["seconds"]
    axes = {"segments", "steps", "stiction", "pairs", "locks", "keys"}
    assert {part["axis"] for part in found["simplifications"]} == axes
    assert (scene.parent / "tuned.toml").read_text() == found["fragment"]

    again, reported = tune(scene, "--tolerance", "20mm")
    assert reported.count("measuring") == 0 and again == found

    stricter, _ = tune(scene, "--tolerance", "0.001 mm", expected=1)
    assert stricter["chosen"] is None and stricter["fragment"] is None
    assert stricter["reference"]["chaotic"] and not found["reference"]["chaotic"]


def test_a_promise_holds_for_easier_motions(scene):
    """Roots of the scene are at rest: those of a copy that a hand moves are outside of what is promised."""
    hand = "roots = { times = [0.0, 0.25], move = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]] }\n"
    driven = SCENE.replace('in.groom = "groom"', 'in = { groom = "groom", ends = "hand" }')
    moved = written(scene, "moved", f'{driven}[hand]\ntype = "drive_ends"\nin.groom = "groom"\nat = 1\n{hand}')
    found, _ = tune(scene, "--tolerance", "20mm", "--check", "--also", str(moved), "--also", str(scene))
    assert found["holds_for"] == {"speed": 0.0, "acceleration": 0.0}
    assert {name: also["within"] for name, also in found["also"].items()} == {str(moved): False, str(scene): True}
    assert found["also"][str(moved)]["speed"] == pytest.approx(0.4, rel=0.7)
    assert len(found["checks"]) == CHECKS and found["kept"]
    assert all(check["chosen"]["error"] <= 0.02 for check in found["checks"])


def test_bad_input_is_reported_before_the_measurements(scene):
    """[hair] of another graph is a groom, or has another name; a tolerance has no unit; nothing moves."""
    groom = written(scene, "groom", SCENE.partition("[hair]")[0].replace("[groom]", "[hair]"))
    wool = written(scene, "wool", SCENE.replace("[hair", "[wool"))
    still = written(scene, "still", SCENE.replace("frames = [1, 8]", "frames = [1, 1]"))
    for path, arguments, message in (
        (scene, ["--tolerance", "20mm", "--also", str(groom)], "does not simulate hair"),
        (scene, ["--tolerance", "20mm", "--also", str(wool)], "no node 'hair'"),
        (scene, ["--tolerance", "2"], "'2' has no unit"),
        (still, ["--tolerance", "2mm"], "a motion needs two frames or more"),
    ):
        result = call(path, *arguments)
        assert result.exit_code == 2 and message in result.stderr and "measuring" not in result.stderr


def test_a_node_that_is_like_another_is_tuned_as_it_is_written_out(scene):
    """The same hair, so that everything is known already; a path that is not English, and a setting that is changed."""
    tune(scene, "--tolerance", "20mm")
    bare = SCENE.replace("[hair]", "[first]").replace("[hair.stiction]", "[first.stiction]")
    other, tuned = written(scene, "é", bare + '[hair]\nlike = "first"\n'), scene.parent / "é_tuned.toml"
    found, reported = tune(other, "--tolerance", "20mm", "--set", "hair.model=chain", "-o", str(tuned))
    assert reported.count("measuring") == 0 and found["kept"]
    assert "--set hair.model=chain" in tuned.read_text(encoding="utf-8")


def test_failed_models_are_listed(scene):
    """A chain is straight: the node that simulates refuses to be one for curls."""
    curls = SCENE.replace("spacing", "curl = { radius = 0.01, pitch = 0.02 }\nspacing").replace('"chain"', '"network"')
    path = written(scene, "curls", curls.replace("segments = 5", "segments = 12"))
    chain = next(part for part in simplifications(opened(path).graph, "hair") if "chain" in part.text)
    sample = choose_sample(range(1, 9), 24.0, None, 8, 8, 4)
    study = Study(request(path), sample, 8)
    assert chain.axis == "model" and "a chain is straight at rest" in study.measure_all([[chain]])[0].fault
    assert not study.measure_all([[]])[0].fault


def test_particles_are_measured_as_any_simplification(scene):
    """A curtain that swings out of the slant; of 96 of its hairs 12 are carried."""
    curtain = SCENE.replace("strands = 8", "strands = 96\ndirection = [0.1, -1.0, 0.0]").replace("0.02]", "0.002]")
    path = written(scene, "curtain", curtain.replace("segments = 5", "segments = 10"))
    part = next(p for p in simplifications(opened(path).graph, "hair") if p.count == 500)
    sample = choose_sample(range(1, 9), 24.0, None, 96, 12, 4)
    found = Study(request(path), sample, 96).measure_all([[part]])[0]
    assert not found.fault and 0.0 < found.tip < 0.05 and found.seconds > 0.0


def test_hair_that_is_chaotic_is_judged_by_members_and_the_same_when_asked_again(scene, capsys):
    """A tuft that is shaken: without collisions a single run stays near, which promises nothing."""
    shaken = SCENE.replace("frames = [1, 8]", "frames = [1, 7]").replace("0.02]", "0.002]\ntuft = { rows = 2 }")
    shaken = shaken.replace("strands = 8", "strands = 4\ndirection = [0.0, -1.0, 0.0]")
    shaken = shaken.replace('in.groom = "groom"', 'in = { groom = "groom", ends = "hand" }')
    hand = '[hair.collisions]\n[hand]\ntype = "drive_ends"\nin.groom = "groom"\nat = 1\n'
    moves = "times = [0.0, 0.05, 0.1, 0.2], move = [[0, 0, 0], [0.04, 0, 0], [-0.04, 0, 0.02], [0, 0, 0]]"
    path = written(scene, "shaken", f"{shaken}{hand}roots = {{ {moves} }}\n")
    asked, found = request(path, tolerance=Tolerance(2e-3, "m"), run=runner(ALONE, quiet=False)), []
    dry = next(part for part in simplifications(opened(path).graph, "hair") if part.axis == "collisions")
    assert look_at(asked).tip == pytest.approx(4e-4)
    reported, sample = [], choose_sample(range(1, 8), 24.0, None, 8, 8, 4)
    with asked.shot.keeping_workers() as shot:
        for _ in range(2):
            study = Study(replace(asked, shot=shot), sample, 8, 4e-4)
            found.append((study.converged(), study.measure_all([[dry]])[0], study.confirm([dry])))
            reported.append("measuring" in capsys.readouterr().err)
    chaos, screened, sure = found[0]
    assert found[0] == found[1] and reported == [True, False]
    assert chaos.chaotic and screened.screened and not sure.screened
    assert sure.climate is not None and sure.bound >= screened.bound


def test_hair_that_touches_none_needs_no_members(scene):
    path = written(scene, "single", SCENE.replace("[hair.stiction]", ""))
    assert look_at(request(path)).tip is None and look_at(request(scene)).tip == pytest.approx(4e-3)
    percent = Tolerance(2.0, "%")
    assert look_at(request(scene, tolerance=percent)).tip == pytest.approx(0.2 * 0.02 * 0.1, rel=1e-6)
    patches = [sample_of(request(graph, strands=6), Scene(8, None, None)).patches for graph in (path, scene)]
    assert patches == [6, 4], "it is sampled strand by strand"


def test_a_cut_is_not_motion(scene):
    """Hair is carried over it: it must not draw the sample to itself."""
    led = SCENE.replace('in.groom = "groom"', 'in = { groom = "groom", ends = "hand" }')
    led += '[hand]\ntype = "drive_ends"\nin.groom = "groom"\nat = 1\n'
    led += "roots = { times = [0.0, 0.125, 0.1666], move = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [5.0, 0.0, 0.0]] }\n"
    texts = (led.replace("fps = 24", "fps = 24\ncuts = [5]"), led)
    motions = [look_at(request(written(scene, "cut", text))).motion for text in texts]
    assert motions[1][3] > 1e3 and motions[1][4] > 1e3
    assert not motions[0].any()


def test_a_result_for_the_shot_takes_its_time_once(scene):
    shot = opened(scene)
    assert not runner(ALONE, quiet=True)("all", shot, ["hair"], shot.frames).failures
    results = Results(shot, shot.frames)
    assert len(results.seconds("groom", [1, 2, 3])) == 1 and len(results.seconds("hair", [1, 2, 3])) == 3


def test_a_full_disk_says_nothing_about_a_model(scene):
    def full(*_, timed) -> Outcome:
        failure = Failure(Task("hair", 3), "disk", "No space left on device")
        return Outcome(0, 0, 0, (failure,), (), {}, {}, False)

    sample = choose_sample(range(1, 9), 24.0, None, 8, 8, 4)
    study = Study(request(scene, run=full), sample, 8)
    with pytest.raises(BadInput, match="hair@3: No space left"):
        study.measure_all([[]])[0]
