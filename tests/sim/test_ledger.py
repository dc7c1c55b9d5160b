"""The ledgers of `hairpipe/sim/` and `hairpipe/particles/`: what their READMEs say of files and tests is so."""

import ast
import re
from pathlib import Path
from typing import NamedTuple

import pytest

HOME = Path(__file__).resolve().parents[2]
STRANDS, PARTICLES = HOME / "hairpipe/laws/README.md", HOME / "hairpipe/particles/README.md"
IN_THE_PAPER = ("Sec. 3.1", "Sec. 3.2", "Sec. 4", "Sec. 4.1", "Sec. 4.2", "Sec. 5.1", "Sec. 5.2", "Sec. 5.3", "Sec. 6")


class Row(NamedTuple):
    """An equation, how its file cites it, and where both are."""

    equation: str
    citation: str
    file: str
    tests: tuple[str, ...]


def read_ledger(readme):
    """Read the rows of the table below "The ledger"."""
    section = readme.read_text(encoding="utf-8").partition("\n## The ledger\n")[2].partition("\n## ")[0]
    rows = [re.split(r"(?<!\\)\|", line.strip("|")) for line in section.splitlines() if line.startswith("|")][2:]
    return [
        Row(cells[0].strip(), cells[1].strip(), cells[2].strip(" `"), tuple(re.findall(r"`([^`]+)`", cells[3])))
        for cells in rows
    ]


def imported(path):
    """Name the modules that a file imports, and what it imports from them."""
    for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(item, ast.ImportFrom):
            yield item.module
            yield from (f"{item.module}.{alias.name}" for alias in item.names)
        elif isinstance(item, ast.Import):
            yield from (alias.name for alias in item.names)


@pytest.mark.parametrize(
    "row", read_ledger(STRANDS) + read_ledger(PARTICLES), ids=lambda row: f"{row.citation}-{Path(row.file).stem}"
)
def test_a_row_names_a_file_that_cites_the_equation_and_tests_that_import_the_file(row):
    file = HOME / row.file
    assert file.is_file(), f"{row.file}: there is no such file"
    text = " ".join(file.read_text(encoding="utf-8").split())
    cited = re.search(re.escape(row.citation) + r"(?!\.?\d)", text, re.IGNORECASE)
    assert cited, f"{row.file} does not cite '{row.citation}'"
    assert row.tests, f"{row.equation}: no test"
    module = f"hairpipe.{row.file.removesuffix('.py').removeprefix('hairpipe/').replace('/', '.')}"
    for test in row.tests:
        assert (HOME / test).is_file(), f"{test}: there is no such file"
        assert module in imported(HOME / test), f"{test} does not import {module}"


def test_every_section_of_the_paper_and_every_step_has_a_row():
    rows = read_ledger(STRANDS)
    assert not [section for section in IN_THE_PAPER if section not in {row.citation for row in rows}]
    groups = re.findall(r"steps? ([\d, and]+)", " ".join(row.equation for row in rows))
    assert sorted(re.findall(r"\d", " ".join(groups))) == list("123456789")


def test_every_equation_of_the_particles_has_a_row():
    """The strength (5) is said where (6) is."""
    cited = [row.citation for row in read_ledger(PARTICLES)]
    assert cited == ["(1)", "(2)", "(3)", "(4)", "(6)", "(7) to (14)", "(15)", "(16) to (18)"]
