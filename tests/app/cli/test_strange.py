"""Names with control characters, and names without end: a message is one line that a terminal only shows."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from .conftest import START

ESCAPE = "a\x1b]0;owned\x07\nb\u202e\u2028c\udce4"
SHOWN = r"a\x1b]0;owned\x07\nb\u202e\u2028c\udce4"
LONG = "x" * 5000
PIPED = {"capture_output": True, "text": True}


def spelt(name: str) -> str:
    """Write a name as TOML does."""
    return "".join(f"\\u{ord(c):04x}" if not c.isprintable() else c for c in name.replace("\udce4", ""))


def is_clean(text: str) -> bool:
    return all(line.isprintable() and len(line) < 2500 for line in text.split("\n"))


SEED = '[seed]\ntype = "make_seed"\n'
PLACES = ['schema = 1\n"{}" = 1\n', '["{}"]\ntype = "make_seed"\n', '[seed]\ntype = "{}"\n', SEED + '"{}" = 1\n']
PLACES += [SEED + line for line in ('file = "{}"\n', 'like = "{}"\n', 'in."{}" = "seed"\n', 'in.seed = "{}"\n')]
PLACES += ['[list]\ntype = "write_list"\nin.numbers = "list"\npublish = "{}/../../x"\n']
"""Places of a graph file where a name stands."""


@pytest.mark.parametrize("name", [ESCAPE, LONG, f"{'y ' * 4000}"])
@pytest.mark.parametrize("text", PLACES)
def test_a_fault_of_a_graph_is_one_line(text, name, shot, hairpipe):
    head = "" if text.startswith("schema") else "schema = 1\nframes = [1, 2]\nfps = 24\n"
    shot.write_text(head + text.replace("{}", spelt(name)), encoding="utf-8")
    result = hairpipe("plan shot.toml")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1 and is_clean(result.stderr)


def test_messages_of_nodes_are_one_line(shot, hairpipe):
    path = Path("nodes") / "make_seed.py"
    text = path.read_text().replace("    tally(", f"    import warnings\n\n    warnings.warn({ESCAPE!r})\n    tally(")
    assert "warnings.warn" in text
    path.write_text(text)
    result = hairpipe("run shot.toml -j1 --to seed")
    assert f"warning: seed: {SHOWN}\n" in result.stderr and is_clean(result.stderr)
    path.write_text(text.replace("warnings.warn(", "raise ValueError("))
    result = hairpipe("run shot.toml -j1 -v --to seed")
    assert f"failed: seed: ValueError: {SHOWN}\n" in result.stderr and is_clean(result.stderr)
    assert "\nTraceback (most recent call last):\n" in result.stderr


def test_paths_of_files_are_one_line(shot, monkeypatch):
    """Names in the graph file are refused if they are not shown; the name of the project is the user's."""
    folder = shot.parent / ESCAPE.replace("\n", "").replace("\udce4", "")
    folder.mkdir()
    shutil.copytree("nodes", folder / "nodes")
    shutil.copy(shot, folder)
    monkeypatch.setenv("HAIRPIPE_TRUST", str(folder / "nodes"))
    result = subprocess.run([*START, "run", f"{folder.name}/shot.toml", "-j1", "--to=list"], **PIPED)
    assert result.returncode == 0, result.stderr
    shown = SHOWN.replace(r"\n", "").replace(r"\udce4", "")
    assert is_clean(result.stdout) and f"{shown}/out/list.txt" in result.stdout


@pytest.mark.parametrize(
    "words", [["plan", ESCAPE], ["run", "shot.toml", "-j", ESCAPE], ["get", "shot.toml", ESCAPE, "-o", "x"]]
)
def test_words_of_the_command_line_are_shown_too(words, shot):
    result = subprocess.run([*START, *words], **PIPED)
    assert result.returncode == 2 and SHOWN in result.stderr and is_clean(result.stderr)


FILES = ["plan {}", "nodes --graph {}", "plan shot.toml --cache {}", "run shot.toml --cache {}", "usd check {}"]
FILES += ["get shot.toml seed -o {}", "tune shot.toml --node sum --tolerance 1mm -o {}"]


@pytest.mark.parametrize("words", FILES)
@pytest.mark.parametrize("kind", ["pipe", "/dev/zero", "/proc/self/environ"])
def test_special_files_are_refused_without_waiting(words, kind, computed, hairpipe):
    os.mkfifo("pipe")
    result = hairpipe(words.format(kind))
    if words.startswith("nodes"):  # only the folder counts
        assert result.exit_code == 0
        return
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    assert f"{kind}: it is " in result.stderr
    assert not Path(kind).is_file() or kind.startswith("/proc")
