"""`hairpipe trust`, and commands that meet a folder of nodes that is not trusted."""

import sys
from contextlib import nullcontext
from pathlib import Path

import click
import pytest

from hairpipe.app.cli.commands.environment import asking
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.file.trust import Untrusted

from ..test_entry import complete


@pytest.fixture
def strange(shot, monkeypatch, tmp_path) -> Path:
    """The shot as somebody else's: nobody trusts its nodes, which leave a mark when they are imported."""
    monkeypatch.delenv("HAIRPIPE_TRUST")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    for path in Path("nodes").glob("*.py"):
        path.write_text(path.read_text() + f"open({str(tmp_path / 'mark')!r}, 'a').write('imported')\n")
    return shot


READ = ["run shot.toml -j1", "plan shot.toml", "graph shot.toml", "explain shot.toml sum@2"]
READ += ["get shot.toml sum@2 -o sum.csv", "cache gc shot.toml --dry-run", "nodes --graph shot.toml make_seed"]


@pytest.mark.parametrize("words", [*READ, "tune shot.toml --node sum --tolerance 1mm"])
def test_no_command_imports_it_and_each_reports_it_in_a_line(words, strange, hairpipe):
    result = hairpipe(words)
    assert result.exit_code == 2 and result.stdout == "" and result.stderr.count("\n") == 1
    assert "/nodes: the code is not trusted: add_up.py, " in result.stderr and "(hairpipe trust /" in result.stderr
    assert not Path("mark").exists()


def test_node_types_are_listed_all_the_same(strange, hairpipe):
    lines = hairpipe("nodes --graph shot.toml").stdout.splitlines()
    (line,) = [line for line in lines if line.startswith("make_seed  ")]
    assert line.endswith(f"hairpipe trust {Path.cwd()}/nodes)")
    assert any(line.startswith("make_bust  ") and "mannequin" in line for line in lines)
    assert not Path("mark").exists()


def test_trusting_listing_and_revoking(strange, hairpipe):
    assert hairpipe("trust --list").stdout == "\n"
    assert hairpipe("trust nodes").stdout.startswith("trusted: nodes: add_up.py, ")
    assert hairpipe("plan shot.toml").exit_code == 0 and Path("mark").exists()
    (Path("nodes") / "tally.py").write_text("changed = True")
    assert hairpipe("plan shot.toml").stderr.startswith(f"hairpipe: {Path.cwd()}/nodes: the code has changed since")
    assert "changed since: tally.py" in hairpipe("trust --list").stdout
    assert hairpipe("trust --revoke nodes").stdout == "no longer trusted: nodes\n"
    assert "is not trusted" in hairpipe("trust --revoke nodes").stderr


@pytest.mark.parametrize(
    ("words", "message"), [("", "Missing argument"), (".", "not a folder of node types"), ("none", "no")]
)
def test_untrustable_folders_are_refused_in_one_message(words, message, strange, hairpipe):
    result = hairpipe(f"trust {words}")
    assert result.exit_code == 2 and message in result.stderr and not Path("config").exists()


@pytest.mark.parametrize("answer", [True, False])
def test_trust_is_asked_on_a_terminal(answer, strange, monkeypatch, capsys):
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(click, "confirm", lambda text, err: answer)
    with nullcontext() if answer else pytest.raises(Untrusted):
        asking(lambda: load_graph(strange))
    assert Path("mark").exists() == answer
    assert "the code is not trusted: add_up.py" in capsys.readouterr().err


def test_completion_imports_nothing(strange):
    complete("run shot.toml --set seed.", strange.parent)
    complete("nodes --graph shot.toml make_", strange.parent)
    assert not Path("mark").exists()
