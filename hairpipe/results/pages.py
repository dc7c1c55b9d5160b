"""Writes figures into pages.

    <!-- results: NAME
    a table or a paragraph in Markdown, with references in braces in place of figures
    -->
    the result, a table below commit, machine and command
    <!-- end -->

NAME is that of a results file, relative to the page; without it, references contain the name. A table of NAME that
refers to other results, too, is below the commits and commands of all. A line of a table whose references match several
rows is repeated for each. Within a line of text the form is `<!-- results: NAME {...} -->`,
the figure, and `<!-- end -->`.
"""

import re
from collections.abc import Callable
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.results.figures import Figures
from hairpipe.results.file import Machine
from hairpipe.results.state import WORDS

MARKER = re.compile(
    r"(?<!`)<!-- results:[ ]*(?P<name>[^\s{|>]*)(?P<template>.*?)-->(?P<made>.*?)<!-- end -->", re.DOTALL
)
OPENING = re.compile(r"(?<!`)<!-- results:")
REFERENCE = re.compile(r"\{([^{}]*)\}")
STATES = re.compile(rf"\((?:{'|'.join(WORDS)})\)")


def written_page(page: Path, text: str, word_of: Callable[[Path], str]) -> str:
    """Return the text of a page with all figures from their results; pure except for reading.

    word_of  returns the word for the state of a results file

    BadInput with page and line for a marker without an end, and for a reference without a target.
    """

    def replaced(match: re.Match[str]) -> str:
        where = f"{page}:{line_of(text, match.start())}"
        opening = text[match.start() : match.start("made")]
        if OPENING.search(match["template"]) or OPENING.search(match["made"]):
            raise BadInput("the marker does not end", where=where, right="<!-- end -->")
        figures = Figures(page.parent, match["name"], word_of)
        try:
            return f"{opening}{made_from(match['template'], match['name'], figures)}<!-- end -->"
        except BadInput as fault:
            raise BadInput(str(fault), where=where) from None

    changed = MARKER.sub(replaced, text)
    if len(OPENING.findall(text)) > len(MARKER.findall(text)):
        last = max(match.start() for match in OPENING.finditer(text))
        raise BadInput("a marker does not end", where=f"{page}:{line_of(text, last)}", right="<!-- end -->")
    return changed


def names_of(text: str) -> list[str]:
    """List the results of a page, relative to it, in order."""
    return list(dict.fromkeys(name for match in MARKER.finditer(text) for name in names_in(*match.group(1, 2))))


def names_in(name: str, template: str) -> list[str]:
    """List the results of a marker and of its references."""
    names = [name]
    for table, _, rest in (reference.partition(";") for reference in REFERENCE.findall(template)):
        names.append(rest.strip() if table.strip() == "state" else table.strip().rpartition(".")[0])
    return list(dict.fromkeys(filter(None, names)))


def without_states(text: str) -> str:
    """Return the text of a page without the states of results, which change with the code."""
    return STATES.sub("()", text)


def made_from(template: str, name: str, figures: Figures) -> str:
    """Return the text between a marker and its end."""
    if "\n" not in template:
        [line] = lines_of(template.strip(), figures)
        return line
    lines = [made for line in template.strip("\n").rstrip().split("\n") for made in lines_of(line, figures)]
    heads = [heading(each, figures) for each in names_in(name, template)] if name and lines[0].startswith("|") else []
    return "\n".join(["", *([";\n".join(heads), ""] if heads else []), *lines, "", ""])


def lines_of(line: str, figures: Figures) -> list[str]:
    """Return the lines of a line of a template: one, or one for every matching row of a table."""
    found = [figures.texts(reference) for reference in REFERENCE.findall(line)]
    count = max(map(len, found), default=1)
    if count > 1 and not line.startswith("|"):
        raise BadInput(f"{count} rows fit", right="COLUMN=VALUE or a reduction, until one does")
    if any(len(texts) not in (1, count) for texts in found):
        raise BadInput(f"the references of a line fit {' and '.join(str(len(t)) for t in found)} rows")
    columns = [iter(texts * (count // len(texts))) for texts in found]
    return [filled(line, [next(column) for column in columns]) for _ in range(count)]


def filled(line: str, texts: list[str]) -> str:
    """Replace references by texts, in order; pure."""
    following = iter(texts)
    return REFERENCE.sub(lambda _: next(following), line)


def heading(name: str, figures: Figures) -> str:
    """Return the source of the figures of a table, and whether they are current."""
    results = figures.results(name)
    commit = f"commit {results.commit[:7]} {figures.word(name)}"
    return f"{commit}; machine {machine_text(results.machine)}; command `{results.command}`"


def machine_text(machine: Machine) -> str:
    """Describe a machine in a line."""
    memory = f", {machine.bandwidth:.3g} GB/s" if machine.bandwidth else ""
    cores = "one core" if machine.cores == 1 else f"{machine.cores} cores"
    return f"{cores} of {machine.processor}{memory}, {machine.kind}, {machine.layer}"


def line_of(text: str, place: int) -> int:
    """Return the line number of a position in a text."""
    return text.count("\n", 0, place) + 1
