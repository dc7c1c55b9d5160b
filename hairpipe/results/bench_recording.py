"""Records what a bench reports: every list of cases as a table, in a results file next to the page that shows it."""

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hairpipe.api.shot import module_recipe
from hairpipe.errors import BadInput
from hairpipe.results.file import Results, ValueTable, file_digest, results_path, write_results
from hairpipe.results.provenance import commit_of, recording_machine


class BenchRecording:
    """Records one report; made before anything is measured.

    folder  of the page
    name    of the results file

    BadInput where code is not committed.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.path, self._folder = results_path(folder, name), folder
        self._commit = commit_of(folder)

    def write(self, report: Any, document: Mapping[str, Any], command: str, files: Iterable[Path]) -> None:
        """Write the tables of a report; BadInput where it has none, OSError where the file cannot be written.

        document  the report as mappings, lists and plain values
        command   that measures the same again
        files     that it has read besides its code
        """
        tables = {name: table for name, cases in document.items() if (table := table_of_cases(cases)) is not None}
        if not tables:
            raise BadInput("the report has no list of cases to record", where=command)
        module = type(report).__module__
        recipe = module_recipe(module)
        names = [os.path.relpath(file, self._folder) for file in files]
        results = Results(
            commit=self._commit,
            machine=recording_machine(bandwidth_of(document)),
            command=command,
            graph=None,
            settings={},
            frames=None,
            module=module,
            processor=round(sum(os.times()[:4]), 2),
            tables=tables,
            nodes={name: file_digest(self._folder / name) for name in names},
            shot=recipe.frames,
            modules=recipe.modules,
            python=recipe.python,
        )
        write_results(self.path, results)


def table_of_cases(cases: Any) -> ValueTable | None:
    """Lay cases out in a table, a field of a field as `field.inner`; None for what is not a list of cases; pure."""
    if not isinstance(cases, list) or not cases or not all(isinstance(case, Mapping) for case in cases):
        return None
    rows = [dict(flattened(case)) for case in cases]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    return ValueTable(columns, [[row.get(name) for name in columns] for row in rows], {})


def flattened(case: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Iterate over the plain values of a case with their names."""
    for name, value in case.items():
        if isinstance(value, Mapping):
            yield from flattened(value, f"{prefix}{name}.")
        elif value is None or isinstance(value, str | int | float):
            yield f"{prefix}{name}", value


def bandwidth_of(document: Mapping[str, Any]) -> float | None:
    """Find the bandwidth of memory that a bench has measured with most threads [GB/s]; None where it has not."""
    triad = document.get("roofs", {}).get("triad", {})
    return round(1e-9 * max(rate["median"] for rate in triad.values()), 1) if triad else None
