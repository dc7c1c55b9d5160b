"""One version, in the package, its metadata, the citation, the changelog and what commands print."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import hairpipe

HOME = Path(__file__).resolve().parents[1]
RELEASE = re.compile(r"^## (\d+\.\d+\.\d+) - (\d{4}-\d\d-\d\d)$", re.M)
MOST_POINTS = 20


def test_the_package_states_its_version_once():
    project = tomllib.loads((HOME / "pyproject.toml").read_text(encoding="utf-8"))
    assert "version" in project["project"]["dynamic"]
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "hairpipe.__version__"}


def test_citation_and_changelog_name_the_version_and_its_date():
    citation = (HOME / "CITATION.cff").read_text(encoding="utf-8")
    stated = re.search(r"^version: (\S+)$", citation, re.M)[1], re.search(r"^date-released: (\S+)$", citation, re.M)[1]
    latest = RELEASE.search((HOME / "CHANGELOG.md").read_text(encoding="utf-8")).groups()
    assert stated == latest and latest[0] == hairpipe.__version__


def test_commands_print_the_version():
    for words in (["version"], ["--version"]):
        printed = subprocess.run(
            [sys.executable, "-c", "from hairpipe.cli import main; main()", *words], capture_output=True, text=True
        ).stdout
        assert printed.split()[:2] == ["hairpipe", hairpipe.__version__]


def test_a_release_begins_with_a_short_list():
    changelog = (HOME / "CHANGELOG.md").read_text(encoding="utf-8")
    begin = RELEASE.search(changelog).end()
    summary = changelog[begin : changelog.index("\n### ", begin)]
    assert 0 < len(re.findall(r"^- ", summary, re.M)) <= MOST_POINTS
