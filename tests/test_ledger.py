"""The ledger of equations: every section, step and equation of the papers is cited by a file that a test imports."""

import sys

import pytest

from .sources import HOME

sys.path.append(str(HOME / "docs"))  # where Sphinx finds the extension, too
ledger = pytest.importorskip("extension.ledger")

SELLE = ("Sec. 3.1", "Sec. 3.2", "Sec. 4", "Sec. 4.1", "Sec. 4.2", "Sec. 5.1", "Sec. 5.2", "Sec. 5.3", "Sec. 6")
BANDO = ("(1)", "(2)", "(3)", "(4)", "(5) and (6)", "(7) to (14)", "(15)", "(16) to (18)")
PETROVIC = ("equation (3) of Petrovic", "Hair as a volume, after Petrovic", "shell")
"""What the heads of files cite of the papers."""


@pytest.mark.parametrize(
    "room, words",
    [
        *((".", words) for words in (*SELLE, *PETROVIC)),
        *(("particles", words) for words in BANDO),
    ],
)
def test_a_file_that_a_test_imports_cites(room, words):
    files = sorted((HOME / "hairpipe" / room).rglob("*.py"))
    cited = [path for path in files if words in " ".join(ledger.docstring_of(path).split())]
    assert any(ledger.tests_of(path) for path in cited), cited


def test_the_nine_steps_are_cited_where_they_are_taken():
    cited = " ".join(" ".join(ledger.citations_in(path)) for path in (HOME / "hairpipe").rglob("*.py"))
    assert all(f"{step}" in cited.replace("Steps", "step") for step in ("step 5", "Step 6", "step 3"))
    assert "nine steps of Sec. 4" in ledger.docstring_of(HOME / "hairpipe/solve/integrators.py")


def test_every_law_has_a_test_and_a_first_line_of_its_own():
    laws = [path for path in (HOME / "hairpipe/laws").glob("*.py") if path.name not in ("__init__.py", "settings.py")]
    assert len({ledger.row_of(path)[0] for path in laws}) == len(laws) > 10
    assert not [path.name for path in laws if not ledger.tests_of(path)]


def test_the_ledger_of_a_file_that_cites_nothing_is_empty():
    assert ledger.citations_in(HOME / "hairpipe/errors.py") == []
