"""Records the report of a benchmark in a results file next to its page."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from hairpipe.graphs.experiments.bench.report import Case, Report
from hairpipe.graphs.experiments.figures.file import Results, ValueTable, file_digest, results_path, write_results
from hairpipe.graphs.experiments.figures.recipe import recipe_of_module
from hairpipe.graphs.experiments.figures.recording import commit_of, recording_machine


class BenchRecording:
    """Records one report; built before the measurement.

    folder  of the page
    name    of the results file

    BadInput if code is not committed.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.path = results_path(folder, name)
        self._folder = folder
        self._commit = commit_of(folder)

    def write(self, report: Report, command: str, files: Iterable[Path]) -> None:
        """Write the tables of a report; OSError if the file cannot be written.

        command  that repeats the measurement
        files    input files in addition to code
        """
        recipe = recipe_of_module(report.module)
        names = [os.path.relpath(file, self._folder) for file in files]
        bandwidth = None if report.bandwidth is None else round(report.bandwidth, 1)
        results = Results(
            commit=self._commit,
            machine=recording_machine(bandwidth),
            command=command,
            graph=None,
            settings={},
            frames=None,
            module=report.module,
            processor=round(sum(os.times()[:4]), 2),
            tables={name: table_of_cases(cases) for name, cases in report.tables.items()},
            nodes={name: file_digest(self._folder / name) for name in names},
            shot=recipe.frames,
            modules=recipe.modules,
            python=recipe.python,
        )
        write_results(self.path, results)


def table_of_cases(cases: Sequence[Case]) -> ValueTable:
    """Return cases as a table; pure."""
    columns = list(dict.fromkeys(name for case in cases for name in case))
    return ValueTable(columns, [[case.get(name) for name in columns] for case in cases], {})
