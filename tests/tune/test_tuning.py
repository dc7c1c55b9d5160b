"""From a graph file to settings: a few hairs that fall."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from hairpipe.cli.entry import commands

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


def tune(scene: Path, *arguments: str, expected: int = 0) -> tuple[dict, str]:
    """Call the command, and give its document and what it said besides."""
    command = ["tune", str(scene), "--node", "hair", "--json", "--cache", str(scene.parent / "cache"), *arguments]
    result = CliRunner().invoke(commands, command, prog_name="hairpipe")
    assert result.exit_code == expected, result.output
    return json.loads(result.stdout), result.stderr


def test_it_measures_chooses_verifies_and_remembers(scene):
    found, said = tune(scene, "--tolerance", "20mm", "-o", str(scene.parent / "tuned.toml"))
    assert "measuring: no stiction" in said
    chosen = found["chosen"]
    assert chosen["bound"] <= 0.02 and found["kept"]
    assert chosen["seconds"] <= found["full"]["seconds"]
    assert {part["axis"] for part in found["simplifications"]} == {"segments", "steps", "stiction"}
    assert (scene.parent / "tuned.toml").read_text() == found["fragment"]

    again, said = tune(scene, "--tolerance", "20mm")
    assert said.count("measuring") == 0 and again == found

    stricter, _ = tune(scene, "--tolerance", "0.001 mm", expected=1)
    assert stricter["chosen"] is None and stricter["fragment"] is None
    assert stricter["simplifications"][0]["tip"] == found["simplifications"][0]["tip"]


def test_a_tolerance_that_says_nothing_is_bad_input(scene):
    command = ["tune", str(scene), "--node", "hair", "--tolerance", "2"]
    result = CliRunner().invoke(commands, command, prog_name="hairpipe")
    assert result.exit_code == 2 and "'2' has no unit" in result.stderr
