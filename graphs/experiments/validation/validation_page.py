"""The page of a validation: rows with bars, and pictures, in one HTML file."""

import base64
import math
from collections.abc import Mapping, Sequence
from html import escape
from itertools import groupby

from hairpipe.app.api.formatting import duration
from hairpipe.graphs.experiments.validation.row import Row
from hairpipe.graphs.experiments.validation.validation import Measured

FULL = 8.0
"""Width of the bar of an error as large as the allowed one [em]."""
LONGEST = 2.0
"""Error over the allowed one at which a bar ends."""
STYLE = f"""body {{ font: 15px/1.45 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em }}
table {{ border-collapse: collapse; width: 100% }}
td, th {{ padding: .15em .6em; text-align: left; vertical-align: top }}
tbody {{ border-top: 1px solid #ccc }} td.number {{ text-align: right; white-space: nowrap }}
small {{ color: #666; display: block }} img {{ max-width: 100% }}
.bar {{ width: {LONGEST * FULL}em; background: linear-gradient(to right, #eee {FULL}em, #fff {FULL}em) }}
.bar div {{ height: .8em; margin-top: .3em; background: #3a7d44 }}
.missed {{ color: #b3261e; font-weight: bold }} .missed .bar div {{ background: #b3261e }}
.unpromised {{ color: #777 }} .unpromised .bar div {{ background: #aaa }}"""


def written_page(
    rows: Sequence[Measured],
    pictures: Mapping[str, bytes],
    heading: str,
    solvers: tuple[list[tuple[str, ...]], str] | None = None,
) -> str:
    """Return the page; pure.

    pictures  PNG, by title
    heading   line below the title
    solvers   lines of a table of other solvers, its header first, and its source; None: no such table
    """
    parts = []
    for _, cases in groupby(rows, lambda measured: measured.row.row):
        found = list(cases)
        parts.append("<tbody>" + "".join(case_line(case, len(found) if case is found[0] else 0) for case in found))
    head = "<tr><th>quantity</th><th>case</th><th>error</th><th>allowed</th><th></th><th>time</th><th></th></tr>"
    figures = [
        f'<h2>{escape(title)}</h2><img alt="" src="data:image/png;base64,{base64.b64encode(data).decode()}">'
        for title, data in pictures.items()
    ]
    if solvers:
        lines, source = solvers
        table = "".join(table_line(line, "th" if line is lines[0] else "td") for line in lines)
        figures.append(f"<h2>Other solvers</h2><p>{escape(source)}</p><table>{table}</table>")
    title = "Validation of hairpipe"
    body = f"<h1>{title}</h1><p>{escape(heading)}</p><table><thead>{head}</thead>{''.join(parts)}</table>"
    opening = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>'
    return "\n".join([opening, body, *figures, "</html>\n"])


def table_line(texts: Sequence[str], tag: str) -> str:
    """Return a line of a table, its cells by their tag."""
    return f"<tr>{''.join(f'<{tag}>{escape(text)}</{tag}>' for text in texts)}</tr>"


def case_line(measured: Measured, cases: int) -> str:
    """Return the line of a case; the first of several cases names the quantity and its source."""
    row = measured.row
    first = f"<td rowspan={cases}>{escape(row.row)}<small>{escape(row.source)}</small></td>" if cases else ""
    share = row.measured / row.allowed
    width = FULL * min(share if math.isfinite(share) else LONGEST, LONGEST)
    numbers = (figure(row, row.measured), figure(row, row.allowed))
    cells = [f"<td>{escape(row.case)}</td>", *(f'<td class="number">{escape(text)}</td>' for text in numbers)]
    cells.append(f'<td><div class="bar"><div style="width: {width:.2f}em"></div></div></td>')
    cells.append(f'<td class="number">{duration(measured.seconds)}</td><td>{row.verdict}</td>')
    kind = {"held": "held", "missed": "missed", "not promised": "unpromised"}[row.verdict]
    return f'<tr class="{kind}">{first}{"".join(cells)}</tr>'


def figure(row: Row, value: float) -> str:
    """Write an error with its unit."""
    return f"{value:.2g} {row.unit}".rstrip() if math.isfinite(value) else "none"
