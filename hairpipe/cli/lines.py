"""Progress as lines, for logs: at begin and end of a node, and every few seconds in between."""

import time

import click

from hairpipe.api.formatting import duration, plural
from hairpipe.api.reports import Event, NodeProgress, NodeSurvey, Progress, Survey, origin
from hairpipe.cli.stderr import echo
from hairpipe.graph.node.messages import one_line

INTERVAL = 5.0
"""Interval of lines about running nodes [s]."""


class NoProgress:
    """Display of warnings and failures only."""

    def begin(self) -> None:
        """Begin to draw."""

    def update(self, event: Event) -> None:
        """Draw nothing."""

    def echo(self, line: str) -> None:
        """Write a line."""
        echo(line)

    def end(self) -> None:
        """Stop drawing."""


class Lines(NoProgress):
    """Display of progress line by line."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._begun: set[str] = set()
        self._done: set[str] = set()
        self._latest = time.monotonic()

    def update(self, event: Event) -> None:
        """Write a line where a node begins or ends, and at intervals in between."""
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
    """Describe a node whose results are all established."""
    if not node.evaluated:
        return "cached"
    cached = f", {node.cached} were cached" if node.cached else ""
    return f"done, {node.evaluated} of {plural(node.total, 'result')} computed{cached}" if cached else "done"


def running_line(node: NodeProgress) -> str:
    """Describe how much of a node is done."""
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
    """Describe how much of a shot is done."""
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
        """Write what has changed; times change always, and are not compared."""
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
        """Write the report at the end of an interval."""
        now = time.monotonic()
        if now - self._latest > INTERVAL:
            self._latest = now
            left = (now - self._begun) / done * (of - done)
            echo(f"{done:,} of {plural(of, self._noun)}, {duration(left)} left")
