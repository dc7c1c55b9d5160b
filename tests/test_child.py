"""Children of this process import what it does, and nothing that lies in the current folder."""

import json
import os
import subprocess
import sys

import pytest

from hairpipe import child

POISON = "import os\nopen(os.environ['POISON'], 'a').write(__file__)\n"


@pytest.fixture
def poisoned(tmp_path, monkeypatch):
    for name in ("json", "sitecustomize", "usercustomize", "hairpipe"):
        (tmp_path / f"{name}.py").write_text(POISON)
    monkeypatch.setenv("POISON", str(tmp_path / "poison"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("variables", [None, "", ":", ":lib", "lib:"])
def test_the_current_folder_is_not_looked_at(poisoned, monkeypatch, variables):
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    monkeypatch.delenv("PYTHONPATH", raising=False)
    if variables is not None:
        monkeypatch.setenv("PYTHONPATH", variables)
    if variables:
        monkeypatch.setattr(sys, "path", [str(poisoned), *sys.path])  # Python has put it there for the empty entry
    found = ask_path()
    assert "" not in found and str(poisoned) not in found and not (poisoned / "poison").exists()


def ask_path() -> list[str]:
    command = child.command("import hairpipe.errors; print(json.dumps(sys.path))")
    return json.loads(subprocess.run(command, env=child.environment(), capture_output=True, check=True).stdout)


def test_named_paths_are_kept(poisoned, monkeypatch):
    """Somebody who names the current folder means it."""
    monkeypatch.setattr(sys, "path", [*sys.path, str(poisoned)])
    monkeypatch.setenv("PYTHONPATH", f"{os.pathsep}{poisoned}")
    assert str(poisoned) in child.search_path() and child.environment()["PYTHONPATH"] == str(poisoned)
