"""Figures of pages: looked up in results files when the documentation is built.

    :::{results} NAME
    :where: COLUMN=VALUE
    a table or a paragraph in Markdown, with references in braces in place of figures
    :::

NAME is that of a results file below `graphs/`: `paper/threads` is `graphs/paper/results/threads.json`. What `where`
says belongs to all references. A table is below commit, machine and command of all results that it refers to; without
a body, it is that of the rows of `check_errors`. Within a line the form is a role, {results}`NAME {...}`.

A reference is `{TABLE; COLUMN; OTHER COLUMN=VALUE; REDUCTION; FORMAT}`, the last three as needed. TABLE may name
another results file before a dot, `volume/shell.table`. VALUE is a text or a number, also a fraction such as 1/240.
Reductions are those of REDUCTIONS, over all matching rows, and COUNT, the number of values that are not empty. FORMAT
is that of Python, `.2g` or `,d`. `{state; NAME}` is the word for current results or those of older code. A line whose
references match several rows is repeated for each.

References of a table share what its lines and columns have in common: a line that begins with an empty cell has the
references of the columns, and the first cell of a line without others adds its own parts to each of them. Either has
table and column, and the other conditions.

    | hair | frame | of it contact |
    | --- | ---: | ---: |
    | | {frames; frame [s]; .2g} | {parts; coupling [s]; .1f} |
    | 5,000 long curly {scene=long_curly} |
    | 10,000 long straight {scene=long_straight} |

    | | {case=network} | {case=rod} |
    | error of the tip [mm] {errors; tip [mm]; largest; .2g} |

Finds results files by page, graph, results file or folder.
"""

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

from hairpipe.engine.node.messages import nearest
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.file import (
    FOLDER,
    Machine,
    Results,
    Value,
    ValueTable,
    read_results,
    results_path,
)
from hairpipe.plain_file import content

GRAPHS = Path(__file__).parents[2]
REDUCTIONS: dict[str, Callable[[Sequence[float]], float]] = {
    "largest": lambda values: max(map(abs, values)),
    "max": max,
    "min": min,
    "mean": lambda values: math.fsum(values) / len(values),
    "sum": math.fsum,
}
"""`largest` is the largest magnitude."""
STATE, COUNT = "state", "count"
FORM = "{TABLE; COLUMN; OTHER COLUMN=VALUE; REDUCTION; FORMAT}"


class Figures:
    """Looks up figures for a page.

    folder   below which results are named
    default  name of the default results, empty for none
    word_of  returns the word for the state of a results file
    """

    def __init__(self, folder: Path, default: str, word_of: Callable[[Path], str]) -> None:
        self._folder, self._default, self._word_of = folder, default, word_of
        self._known: dict[str, Results] = {}

    def results(self, name: str) -> Results:
        """Return the results of this name; BadInput if they cannot be read."""
        if name not in self._known:
            self._known[name] = read_results(results_path(self._folder, name))
        return self._known[name]

    def word(self, name: str) -> str:
        """Return the word for the state of the results of this name, in brackets."""
        return f"({self._word_of(results_path(self._folder, name))})"

    def texts(self, reference: str) -> list[str]:
        """Return the value of a reference in all matching rows; BadInput for an unknown name, or without a match."""
        table, *parts = [part.strip() for part in reference.split(";")]
        if not parts:
            raise BadInput(f"'{{{reference}}}' has no column", right=FORM)
        column, *rest = parts
        if table == STATE:
            return [self.word(column)]
        found = self._table(table)
        wanted = dict(part.split("=", 1) for part in rest if "=" in part)
        values: Sequence[Value] = values_of(found, column, wanted)
        spec = ""
        for part in rest:
            if part == COUNT:
                values = [sum(value not in ("", None) for value in values)]
            elif part in REDUCTIONS:
                values = [reduced(part, values)]
            elif "=" not in part:
                spec = part
        return [written(value, spec) for value in values]

    def _table(self, reference: str) -> ValueTable:
        name, _, table = reference.rpartition(".")
        tables = self.results(name or self._default).tables
        if table not in tables:
            raise BadInput(f"no table '{table}'", right=nearest(table, list(tables)))
        return tables[table]


def values_of(table: ValueTable, column: str, wanted: dict[str, str]) -> list[Value]:
    """Return the values of a column in the rows with the wanted values; BadInput if there are none."""
    for name in (column, *wanted):
        if name not in table.columns:
            raise BadInput(f"no column '{name}'", right=nearest(name, table.columns))
    places = {table.columns.index(name): value for name, value in wanted.items()}
    rows = [row for row in table.rows if all(is_equal(row[place], text) for place, text in places.items())]
    if not rows:
        raise BadInput(f"no row with {', '.join(f'{name}={value}' for name, value in wanted.items())}")
    return [row[table.columns.index(column)] for row in rows]


def is_equal(value: Value, text: str) -> bool:
    """Whether a value equals that of a page: numbers by value, others as text."""
    if isinstance(value, int | float):
        try:
            return value == float(Fraction(text))
        except (ValueError, ZeroDivisionError):
            return False
    return value == text


def reduced(name: str, values: Sequence[Value]) -> float:
    """Reduce values to one number; BadInput if one is not a number."""
    numbers = [value for value in values if isinstance(value, int | float)]
    if len(numbers) < len(values):
        raise BadInput(f"'{name}' of values that are not all numbers", right="a column of finite numbers")
    return REDUCTIONS[name](numbers)


def written(value: Value, spec: str) -> str:
    """Return a value in a format; a dash if there is no value.

    Large numbers have no exponent, exponents no leading zero, and `#.2g`, which keeps the zeros of 2.0, no final point.
    """
    if value is None:
        return "-"
    try:
        text = format(value, spec)
    except ValueError:
        raise BadInput(f"'{spec}' does not apply to {value!r}", right="a format of Python, such as .2g") from None
    text = f"{float(text):,.0f}" if "e+" in text else text.replace("e-0", "e-") if spec else text
    return text.removesuffix(".") if spec.startswith("#") else text


DIRECTIVE = re.compile(r"^:::\{results\} (?P<name>\S+)\n(?P<body>(?:.*\n)*?):::$", re.MULTILINE)
ROLE = re.compile(r"\{results\}`(?P<name>[^\s{`]*)(?P<body>[^`]*)`")
REFERENCE = re.compile(r"\{([^{}]*)\}")
ROWS = [
    "| error | case | measured | allowed | |",
    "| --- | --- | ---: | ---: | --- |",
    "| {rows; row} | {rows; case} | {rows; measured; .2g} {rows; unit} "
    "| {rows; allowed; .2g} {rows; unit} | {rows; verdict} |",
]
"""Body of a directive without one: the rows of `check_errors`."""


def markdown_of(name: str, lines: Sequence[str], where: str, word_of: Callable[[Path], str]) -> str:
    """Return the Markdown of a directive; BadInput for a reference without a target.

    where    parts of all references, such as `frame=1013`; empty for none
    word_of  returns the word for the state of a results file
    """
    figures = Figures(GRAPHS, name, word_of)
    body = [with_parts(line, where) for line in expanded(list(lines) or ROWS)]
    made = [text for line in body for text in lines_of(line, figures)]
    names = names_in(name, "\n".join(body))
    heads = [heading(each, figures) for each in names] if made[0].startswith("|") else []
    return "\n".join([*([";\n".join(heads), ""] if heads else []), *made])


def figure_of(name: str, text: str, word_of: Callable[[Path], str]) -> str:
    """Return the text of a role; BadInput for a reference without a target."""
    [line] = lines_of(text.strip(), Figures(GRAPHS, name, word_of))
    return line


def expanded(lines: Sequence[str]) -> list[str]:
    """Return the lines of a table in which each line has its own references; pure."""
    columns: list[str] = []
    found = []
    for line in lines:
        first, *others = line.strip().strip("|").split("|") if line.startswith("|") else [line]
        if line.startswith("|") and not first.strip() and REFERENCE.search(line):
            columns = others
        elif line.startswith("|") and columns and not others:
            own = "; ".join(REFERENCE.findall(first))
            cells = [REFERENCE.sub("", first), *(with_parts(column, own) for column in columns)]
            found.append(f"|{'|'.join(cells)}|")
        else:
            found.append(line)
    return found


def with_parts(text: str, parts: str) -> str:
    """Return a text with parts added to its references: before conditions, where the parts name a column; pure."""

    def extended(match: re.Match[str]) -> str:
        own = match[1].strip()
        is_condition = "=" in own.partition(";")[0]
        return "{" + "; ".join(filter(None, [parts, own] if is_condition else [own, parts])) + "}"

    return REFERENCE.sub(extended, text)


def names_of(text: str) -> list[str]:
    """List the results of a page, in order."""
    found = [(match["name"], match["body"]) for form in (DIRECTIVE, ROLE) for match in form.finditer(text)]
    return list(dict.fromkeys(name for given, body in found for name in names_in(given, body)))


def names_in(name: str, template: str) -> list[str]:
    """List the results of a directive and of its references."""
    names = [name]
    for table, _, rest in (reference.partition(";") for reference in REFERENCE.findall(template)):
        if "=" not in table:
            names.append(rest.strip() if table.strip() == STATE else table.strip().rpartition(".")[0])
    return list(dict.fromkeys(filter(None, names)))


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


PAGE, GRAPH, RESULTS = ".md", ".toml", ".json"
RIGHT = "a page (.md), a graph (.toml), a results file (.json), or a folder"


def find_results(given: Iterable[Path]) -> list[Path]:
    """List the results files of pages, graphs and folders; BadInput for other paths."""
    found: dict[Path, None] = {}
    for path in given:
        if path.is_dir():
            found |= dict.fromkeys(file for file in files_below(path, RESULTS) if file.parent.name == FOLDER)
        elif path.suffix == PAGE:
            found |= dict.fromkeys(results_path(GRAPHS, name) for name in names_of(read_page(path)))
        elif path.suffix == GRAPH and path.is_file():
            files = sorted((path.parent / FOLDER).glob(f"*{RESULTS}"))
            found |= dict.fromkeys(file for file in files if read_results(file).graph == path.name)
        elif path.suffix == RESULTS:
            found[path] = None
        else:
            raise BadInput("no results belong to it", where=path, right=RIGHT)
    return list(found)


def read_page(path: Path) -> str:
    """Read a page; BadInput if it cannot be read."""
    try:
        return content(path, "a page").decode("utf-8")
    except UnicodeDecodeError:
        raise BadInput("not text in UTF-8", where=path, right="a page") from None


def files_below(folder: Path, suffix: str) -> Iterator[Path]:
    """Iterate over files with a suffix below a folder, in order, without hidden folders."""
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        yield from (Path(place, name) for name in sorted(files) if name.endswith(suffix))
