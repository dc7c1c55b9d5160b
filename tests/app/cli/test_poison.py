"""Folders full of modules that are called as others: no command runs one of them."""

import os
import shutil
import subprocess
import sys

import pytest

POISON = "import os\nopen(os.environ['POISON'], 'a').write(__file__ + ' ')\n"
NAMES = ("json", "numpy", "h5py", "click", "numba", "random", "sitecustomize", "usercustomize", "yaml")
PACKAGES = ("pxr", "hairpipe", "scipy")
START = [sys.executable, "-P", "-c", "from hairpipe.cli import main; main()"]  # as the script that pip makes does


@pytest.fixture(scope="module")
def poisoned(result, tmp_path_factory):
    """A copy of the shot after a run, with modules that are called as others in its folder and in that of its nodes."""
    shot = tmp_path_factory.mktemp("poisoned") / "shot"
    shutil.copytree(result, shot)
    for folder in (shot, shot / "nodes"):
        for name in NAMES:
            (folder / f"{name}.py").write_text(POISON)
        for name in PACKAGES:
            (folder / name).mkdir()
            (folder / name / "__init__.py").write_text(POISON)
    (shot / "scene.usda").write_text('#usda 1.0\ndef Xform "a" {}\n')
    return shot


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("run shot.toml -j1 --set seed.value=4 --frames 1-2", 0),
        ("plan shot.toml", 0),
        ("graph shot.toml", 0),
        ("explain shot.toml sum@2", 0),
        ("get shot.toml sum@2 -o sum.csv", 2),
        ("usd check scene.usda", 1),
        ("cache verify", 0),
        ("tune shot.toml --node sum --tolerance 1mm", 2),
    ],
)
def test_no_command_imports_what_lies_about(poisoned, words, code):
    poison = poisoned / "poison"
    variables = {"TOY_TALLY": str(poisoned / "tally"), "HAIRPIPE_TRUST": str(poisoned / "nodes")}
    environment = os.environ | variables | {"POISON": str(poison)}
    done = subprocess.run([*START, *words.split()], cwd=poisoned, env=environment, capture_output=True, text=True)
    assert not poison.exists(), poison.read_text()
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
