"""Display of runs on the terminal: bars drawn by rich, or lines for logs, and reports as messages and documents.

Lines are written at begin and end of a node, and every few seconds in between.
"""

import os
import sys
import time
from typing import Any, Self

import click
from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.spinner import Spinner
from rich.table import Table

from hairpipe.app.api.formatting import duration, plural
from hairpipe.app.api.reports import Event, Graph, NodeProgress, NodeSurvey, Progress, Run, Survey, origin
from hairpipe.app.api.shot import NOTICE, compiles_first
from hairpipe.app.cli.stderr import echo
from hairpipe.engine.node.messages import one_line

INTERVAL = 5.0  # interval of lines about running nodes [s]


class Silence:
    """Display of warnings and failures only."""

    def begin(self) -> None: ...

    def update(self, event: Event) -> None: ...

    def echo(self, line: str) -> None:
        echo(line)

    def end(self) -> None: ...


class Lines(Silence):
    """Display of progress line by line."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._begun: set[str] = set()
        self._done: set[str] = set()
        self._latest = time.monotonic()

    def update(self, event: Event) -> None:
        if event.task is None:
            return
        name = origin(event.task.node)
        node = self._progress.nodes[name]
        if event.kind == "started" and name not in self._begun:
            self._begun.add(name)
            echo(f"{name}: begins")
        elif node.done == node.total and name not in self._done and event.kind in ("finished", "cached"):
            self._done.add(name)
            echo(f"{name}: {done_line(node)}")
        elif time.monotonic() - self._latest > INTERVAL:
            self._latest = time.monotonic()
            for other, progress in self._progress.nodes.items():
                # No frame of the node is running.
                if other in self._begun - self._done:
                    echo(f"{other}: {running_line(progress)}")


def done_line(node: NodeProgress) -> str:
    if not node.evaluated:
        return "cached"
    cached = f", {node.cached} were cached" if node.cached else ""
    return f"done, {node.evaluated} of {plural(node.total, 'result')} computed{cached}" if cached else "done"


def running_line(node: NodeProgress) -> str:
    parts = [f"{node.done}/{node.total}"]
    if node.seconds_per_frame is not None and node.seconds_left is not None:
        parts += [f"{duration(node.seconds_per_frame)} each", f"{duration(node.seconds_left)} left"]
    return ", ".join(parts)


def survey_notes(node: NodeSurvey) -> str:
    """Describe the results of a node that do not exist: where they are computed or failed, and how many wait."""
    hosts = ", ".join(f"{host} {count}" for host, count in sorted(node.hosts.items()))
    counts = {"missing": node.missing, "waiting for inputs": node.waiting, "lost, diverged": node.diverged}
    parts = [f"computing: {hosts}"] * bool(hosts) + [f"{count} {note}" for note, count in node.failures.items()]
    return "; ".join(parts + [f"{count} {state}" for state, count in counts.items() if count])


def survey_line(survey: Survey) -> str:
    done = list(survey.states.values()).count("computed")
    machines = plural(len(set(survey.hosts.values())), "machine")
    parts = [f"{done:,} of {plural(len(survey.states), 'result')}"]
    if survey.hosts:
        parts.append(f"{len(survey.hosts):,} being computed on {machines}")
    elif not survey.complete:
        parts.append("none being computed")
    if survey.seconds_left is not None:
        parts.append(f"{duration(survey.seconds_left)} left")
    return ", ".join(parts)


class SurveyLines:
    """Lines about the nodes of a shot that have changed, and its total; call it with each state."""

    def __init__(self) -> None:
        self._latest: dict[str, tuple[int, int, str]] = {}

    def __call__(self, survey: Survey) -> None:
        nodes = survey.nodes
        states = {name: (node.done, node.total, survey_notes(node)) for name, node in nodes.items()}
        if states == self._latest:
            return
        for name, node in nodes.items():
            if states[name] != self._latest.get(name):
                notes = states[name][-1]
                click.echo(one_line(f"{name}: {running_line(node)}{'; ' * bool(notes)}{notes}"))
        self._latest = states
        click.echo(survey_line(survey))


class Steps:
    """Report of a number of equal steps every few seconds, with the time left; called with done and total.

    noun  name of the product of a step
    """

    def __init__(self, noun: str) -> None:
        self._noun = noun
        self._begun = self._latest = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        now = time.monotonic()
        if now - self._latest > INTERVAL:
            self._latest = now
            left = (now - self._begun) / done * (of - done)
            echo(f"{done:,} of {plural(of, self._noun)}, {duration(left)} left")


WIDTH = 30
REFRESHES = 8  # pictures per second [1/s]


class Bars(Silence):
    """Display of a bar per running node: frames done, seconds per frame, time left, cached frames."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._spinner = Spinner("dots")
        console = Console(stderr=True, highlight=False)
        self._live = Live(console=console, refresh_per_second=REFRESHES, transient=True)

    def begin(self) -> None:
        self._live.start()

    def end(self) -> None:
        self._live.stop()

    def update(self, event: Event) -> None:
        """Lay out new rows, and do not change the old ones: the drawing thread may read them at any time."""
        self.rows = Table.grid(padding=(0, 2))
        for name, node in self._progress.nodes.items():
            if node.running or (node.evaluated and node.done < node.total):
                self.rows.add_row(self._spinner, name, *cells(node))
        self._live.update(self.rows)

    def echo(self, line: str) -> None:
        self._live.console.print(one_line(line), markup=False, soft_wrap=True)


def cells(node: NodeProgress) -> list[ProgressBar | str]:
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
        self.end = self._live.stop

    def __call__(self, survey: Survey) -> None:
        """Draw a state in place of the last one, its total first: a small window does not show all rows."""
        rows = Table.grid(padding=(0, 2))
        for name, node in survey.nodes.items():
            rows.add_row(name, *cells(node), one_line(survey_notes(node)))
        self._live.start()
        self._live.update(Group(survey_line(survey), rows), refresh=True)


class RunDisplay:
    """Context that receives the events of a run, and draws its progress: bars on a terminal, or lines."""

    def __init__(self, graph: Graph, jobs: int, *, quiet: bool) -> None:
        self.progress = Progress(graph, jobs)
        self._warnings: set[tuple[str, str]] = set()
        bars = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
        self._drawing = Silence() if quiet else Bars(self.progress) if bars else Lines(self.progress)
        self._compiles = not quiet and compiles_first(graph)

    def __call__(self, event: Event) -> None:
        """Show an event; the same warning of a node once for all frames."""
        self.progress.update(event)
        if event.kind == "started" and self._compiles:
            self._compiles = False
            self._drawing.echo(NOTICE)
        if event.kind == "warning" and event.task is not None:
            if (event.task.node, event.message) not in self._warnings:
                self._warnings.add((event.task.node, event.message))
                self._drawing.echo(f"warning: {event.task}: {event.message}")
        elif event.kind == "failed":
            self._drawing.echo(f"failed: {event.task}: {event.message}")
        self._drawing.update(event)

    def __enter__(self) -> Self:
        self._drawing.begin()
        return self

    def __exit__(self, *error: object) -> None:
        self._drawing.end()


def report_faults(done: Run, verbose: bool) -> None:
    """Report failed and unreached nodes, and repeated warnings."""
    outcome = done.outcome
    for line in done.warning_lines(fewest=2):
        echo(line)
    for failure in outcome.failures:
        if verbose and failure.traceback:
            for line in ("", str(failure.task), *failure.traceback.split("\n")):
                echo(line)
    if outcome.failures:
        names = ", ".join(str(failure.task) for failure in outcome.failures)
        missed = f"; {plural(outcome.blocked, 'result')} not reached" if outcome.blocked else ""
        raised = any(failure.kind in ("node", "diverged") and failure.traceback for failure in outcome.failures)
        hint = "; -v shows where in the code" if raised and not verbose else ""
        echo(f"hairpipe: {names} failed{missed}{hint}")
    elif outcome.leased:
        echo(f"hairpipe: other processes compute {plural(outcome.leased, 'result')}; run again")
    elif outcome.blocked and not outcome.interrupted:
        echo(
            f"hairpipe: {plural(outcome.blocked, 'result')} not reached: what they need is at frames outside of --only"
        )
    if outcome.interrupted:
        echo("hairpipe: interrupted; computed results are kept, and the same command resumes")


def document(done: Run) -> dict[str, Any]:
    """Describe a run as a JSON document."""
    outcome = done.outcome
    return {
        "graph": str(done.graph.path),
        "cache": str(done.shot.cache),
        "frames": list(done.frames),
        "exit_code": outcome.exit_code,
        "interrupted": outcome.interrupted,
        "seconds": done.seconds,
        "evaluated": outcome.evaluated,
        "cached": outcome.cached,
        "blocked": outcome.blocked,
        "stopped": done.stopped,
        "nodes": {
            name: {
                "total": node.total,
                "evaluated": node.evaluated,
                "cached": node.cached,
                "seconds": outcome.seconds.get(name, 0.0),
                "processor": outcome.processor.get(name, 0.0),
                "compiling": outcome.compiled.get(name, 0.0),
            }
            for name, node in done.progress.items()
        },
        "published": list(outcome.published),
        "failures": [
            fault.task._asdict() | {name: getattr(fault, name) for name in ("kind", "message", "traceback")}
            for fault in outcome.failures
        ],
        "warnings": [
            {"node": node, "frames": [task.frame for task in tasks], "message": message}
            for (node, message), tasks in done.warnings.items()
        ],
    }
