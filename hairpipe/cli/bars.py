"""Progress as bars, one for every running node, or for every node of a survey; drawn by rich on a terminal."""

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.spinner import Spinner
from rich.table import Table

from hairpipe.api.formatting import duration
from hairpipe.api.reports import Event, NodeProgress, Progress, Survey
from hairpipe.cli.lines import survey_line, survey_notes
from hairpipe.graph.node.messages import one_line

WIDTH = 30
REFRESHES = 8
"""Pictures per second [1/s]."""


class Bars:
    """Display of a bar per running node: frames done, seconds per frame, time left, cached frames.

    rows  visible rows
    """

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._console = Console(stderr=True, highlight=False)
        self._spinner = Spinner("dots")
        self.rows: Table = Table.grid()
        self._live = Live(
            get_renderable=lambda: self.rows, console=self._console, refresh_per_second=REFRESHES, transient=True
        )

    def begin(self) -> None:
        """Begin to draw."""
        self._live.start()

    def update(self, event: Event) -> None:
        """Lay out new rows, and do not change the old ones: the drawing thread may read them at any time."""
        rows = Table.grid(padding=(0, 2))
        for name, node in self._progress.nodes.items():
            if node.running or (node.evaluated and node.done < node.total):
                rows.add_row(self._spinner, name, *cells(node))
        self.rows = rows

    def echo(self, line: str) -> None:
        """Write a line above the bars."""
        self._console.print(one_line(line), markup=False, soft_wrap=True)

    def end(self) -> None:
        """Remove the bars."""
        self._live.stop()


def cells(node: NodeProgress) -> list[ProgressBar | str]:
    """Write the progress of a node."""
    rate, left = node.seconds_per_frame, node.seconds_left
    return [
        ProgressBar(node.total, node.done, width=WIDTH),
        f"{node.done}/{node.total}",
        "" if rate is None or node.total == 1 else f"{duration(rate)}/frame",
        "" if not left else f"{duration(left)} left",
        f"{node.cached} cached" if node.cached else "",
    ]


class SurveyBars:
    """Display of a bar for every node of a shot, with the machines that compute; call it with each state."""

    def __init__(self) -> None:
        self._live = Live(console=Console(highlight=False, markup=False), auto_refresh=False)

    def __call__(self, survey: Survey) -> None:
        """Draw a state in place of the last one, its total first: a small window does not show all rows."""
        rows = Table.grid(padding=(0, 2))
        for name, node in survey.nodes.items():
            rows.add_row(name, *cells(node), one_line(survey_notes(node)))
        self._live.start()
        self._live.update(Group(survey_line(survey), rows), refresh=True)

    def end(self) -> None:
        """Leave the last state, and the cursor as it was."""
        self._live.stop()
