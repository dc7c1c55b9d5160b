"""`hairpipe farm`: its tasks, in any order, by any manager, give what one run gives, and evaluate nothing twice."""

import json
import os
import random
import shlex
import subprocess
import sys
from collections import Counter
from math import prod
from pathlib import Path

import pytest
from click.testing import CliRunner

from hairpipe.app.cli.entry import commands
from hairpipe.app.farm import MOST_TASKS

from ..cli.conftest import START

OPENJD = Path(sys.executable).parent / "openjd"
needs_openjd = pytest.mark.skipif(not OPENJD.exists(), reason="openjd-cli is not installed (the extra `farm`)")


def call(words: list[str]) -> int:
    """Run a command in this process; its exit code."""
    return CliRunner().invoke(commands, words[1:], prog_name="hairpipe").exit_code


def state_of(cache: str = "cache") -> tuple[dict[str, bytes], set[str], Counter]:
    """Published files, keys of results, and the number of evaluations by node type since the last call."""
    tally = Path("tally")
    counts = Counter(line.split()[0] for line in tally.read_text().splitlines())
    tally.unlink()
    files = {path.relative_to("out").as_posix(): path.read_bytes() for path in Path("out").rglob("*") if path.is_file()}
    return files, {path.stem for path in Path(cache, "actions").glob("*/*.json")}, counts


def undisturbed(hairpipe, arguments: str):
    """Run the shot at once with a store of its own; its state, with nothing left published."""
    assert hairpipe(f"run shot.toml {arguments} -j1 --cache whole").exit_code == 0
    found = state_of("whole")
    for path in Path("out").rglob("*.txt"):
        path.unlink()
    return found


def lines_of(hairpipe, arguments: str) -> list[list[str]]:
    """Write the commands of the shot and read them."""
    assert hairpipe(f"farm shot.toml {arguments} --format commands -o job").exit_code == 0
    text = Path("job", "commands.txt").read_text()
    return [shlex.split(line) for line in text.splitlines() if not line.startswith("#")]


def test_steps_follow_the_graph(wedged, hairpipe):
    done = hairpipe("farm shot.toml --chunk 4 -o job")
    assert done.exit_code == 0, done.stderr
    steps = json.loads(Path("job", "job.json").read_text())["steps"]
    assert [step["name"] for step in steps] == ["once", "frames-1", "scans-1", "frames-2", "collect"]
    parts = [
        step["parameterSpace"]["taskParameterDefinitions"][0]["range"] for step in steps if "parameterSpace" in step
    ]
    assert parts == [["1-4", "5-6"], ["1-4", "5-6"]]
    (scans,) = [line for line in lines_of(hairpipe, "--wedge steps") if "sum[step=2]" in line]
    assert scans[-2:] == ["--to", "sum[step=2]"]


def test_variants_are_tasks_of_their_own_after_what_they_share(wedged, hairpipe):
    """With one frame, a shot cannot be divided otherwise."""
    wedged.write_text(wedged.read_text().replace("[1.0, 2.0]", str([float(step) for step in range(1, 17)])))
    hairpipe("farm shot.toml --wedge steps --frames 1 --chunk 10 -o job")
    steps = json.loads(Path("job", "job.json").read_text())["steps"]
    spaces = {s["name"]: s.get("parameterSpace", {"taskParameterDefinitions": []}) for s in steps}
    tasks = {name: prod(len(p["range"]) for p in space["taskParameterDefinitions"]) for name, space in spaces.items()}
    assert tasks["once"] == 1 and next(iter(tasks)) == "once"
    assert tasks["scans-1"] == tasks["frames-2-variants"] == tasks["collect-variants"] == 16
    lines = lines_of(hairpipe, "--wedge steps --frames 1")
    assert len(lines) == sum(tasks.values())
    assert ["--to", "drawing[step=3] soft[step=3]", "--only", "1"] in [line[-4:] for line in lines]


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("wedge", ["", "--wedge steps"])
def test_shuffled_commands_give_what_one_run_gives(wedged, hairpipe, seed, wedge):
    expected = undisturbed(hairpipe, wedge)
    lines = lines_of(hairpipe, f"{wedge} --chunk 2")
    random.Random(seed).shuffle(lines)
    assert [call([*line, "-j1", "-q"]) for line in lines] == [0] * len(lines)
    assert state_of() == expected
    assert call(shlex.split(f"hairpipe plan shot.toml {wedge} --missing")) == 0


def test_a_task_alone_computes_what_it_needs(wedged, hairpipe):
    """The last chunk first: it evaluates the scan, and the file of all frames is not there."""
    lines = lines_of(hairpipe, "--chunk 2")
    last = next(line for line in lines if line[-1] == "5-6" and "soft" in line)
    assert call([*last, "-j1"]) == 0
    assert Counter(line.split()[0] for line in Path("tally").read_text().splitlines())["add_up"] == 6
    assert call(shlex.split("hairpipe plan shot.toml --missing")) == 1


def test_settings_enter_every_command(wedged, hairpipe):
    lines = lines_of(hairpipe, "--set move.step=3 --frames 2-5 --chunk 9")
    assert all("move.step=3" in line and "2-5" in line for line in lines)


def test_too_many_tasks_for_a_step_are_refused(wedged, hairpipe):
    wedged.write_text(wedged.read_text().replace("[1, 6]", f"[1, {MOST_TASKS + 1}]"))
    result = hairpipe("farm shot.toml --chunk 1 -o job")
    assert result.exit_code == 2 and "a larger --chunk" in result.stderr
    assert hairpipe("farm shot.toml --chunk 2 -o job").exit_code == 0


@needs_openjd
def test_open_job_description_takes_the_job(wedged, hairpipe):
    assert hairpipe("farm shot.toml --wedge steps --chunk 3 -o job").exit_code == 0
    done = subprocess.run([OPENJD, "check", "job/job.json"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


@needs_openjd
@pytest.mark.slow
def test_open_job_description_runs_the_job(wedged, hairpipe, tmp_path):
    """All steps in their order, by `openjd run`, give what one run gives."""
    expected = undisturbed(hairpipe, "")
    hairpipe("farm shot.toml --chunk 3 -o job")
    program = tmp_path / "bin" / "hairpipe"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\n{START[2]}")
    program.chmod(0o755)
    command = [OPENJD, "run", "job/job.json", "--step", "collect", "--run-dependencies"]
    command += ["-p", f"Graph={tmp_path / 'shot.toml'}", "-p", f"Cache={tmp_path / 'cache'}"]
    path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, env=os.environ | {"PATH": path})
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr
    assert state_of() == expected
