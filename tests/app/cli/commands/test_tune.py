"""`hairpipe tune`: where the settings go. What is tuned is made up; tests/app/tune does it in earnest."""

import tomllib
from pathlib import Path

import pytest

from hairpipe.app.tune import tuning
from hairpipe.app.tune.measured import Measured, Tolerance
from hairpipe.app.tune.sampling import Sample
from hairpipe.app.tune.tuning import Choice, Tuned
from hairpipe.engine.store import atomic
from hairpipe.values.simplification import Simplification

SLOWER = Simplification("value", 1, "a smaller seed", (("seed.value", 2),))
FOUND = Measured(0.001, 0.001, 2.5, 0.001, 0.001, 0.001)
TUNED = Tuned(
    strands=10,
    sample=Sample(10, 1, 0, 1, 1, 6),
    tolerance=Tolerance(2e-3, "m"),
    reference=FOUND,
    steps="steps up to 1/960 s",
    full=FOUND,
    singles={SLOWER: FOUND},
    choice=Choice(frozenset([SLOWER]), FOUND, ()),
)
TUNE = "tune shot.toml --node sum --tolerance 2mm -q"


@pytest.fixture
def tuned(shot: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The shot, with an outcome that is there at once."""
    monkeypatch.setattr(tuning, "tune", lambda task, echo: TUNED)
    return shot


def test_settings_go_to_a_file_that_appears_whole(tuned, hairpipe):
    result = hairpipe(f"{TUNE} -o tuned.toml")
    assert result.exit_code == 0 and result.stdout.endswith("settings: tuned.toml\n")
    assert tomllib.loads(Path("tuned.toml").read_text()) == {"seed": {"type": "make_seed", "value": 2}}
    assert result.stdout.partition("\n")[0] == hairpipe(TUNE).stdout.partition("\n")[0]


def test_findings_are_printed_if_the_file_cannot_be_written(tuned, hairpipe, monkeypatch):
    def full(path: Path) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(atomic, "flush", full)
    Path("tuned.toml").write_text("old")
    result = hairpipe(f"{TUNE} -o tuned.toml")
    assert result.exit_code == 2 and result.stderr == "hairpipe: No space left on device\n"
    assert "a smaller seed" in result.stdout and Path("tuned.toml").read_text() == "old"


@pytest.mark.parametrize(
    ("output", "message"),
    [("none/tuned.toml", "none: no such folder"), ("nodes", "is not a file"), ("/dev/null", ": it is a device")],
)
def test_unwritable_output_is_refused_before_measuring(output, message, shot, hairpipe):
    result = hairpipe(f"{TUNE} -o {output}")
    assert result.exit_code == 2 and message in result.stderr
    assert not Path("cache").exists()
