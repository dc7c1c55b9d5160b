"""Report of a run, as messages and as a document."""

from typing import Any

from hairpipe.api.formatting import plural
from hairpipe.api.reports import Failure, Run
from hairpipe.cli.stderr import echo


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
    return {
        "graph": str(done.graph.path),
        "cache": str(done.shot.cache),
        "frames": list(done.frames),
        "exit_code": done.outcome.exit_code,
        "interrupted": done.outcome.interrupted,
        "seconds": done.seconds,
        "evaluated": done.outcome.evaluated,
        "cached": done.outcome.cached,
        "blocked": done.outcome.blocked,
        "stopped": done.stopped,
        "nodes": {
            name: {
                "total": node.total,
                "evaluated": node.evaluated,
                "cached": node.cached,
                "seconds": done.outcome.seconds.get(name, 0.0),
                "processor": done.outcome.processor.get(name, 0.0),
            }
            for name, node in done.progress.items()
        },
        "published": list(done.outcome.published),
        "failures": [failure.task._asdict() | described(failure) for failure in done.outcome.failures],
        "warnings": [
            {"node": node, "frames": [task.frame for task in tasks], "message": message}
            for (node, message), tasks in done.warnings.items()
        ],
    }


def described(failure: Failure) -> dict[str, str]:
    """Describe a failure."""
    return {"kind": failure.kind, "message": failure.message, "traceback": failure.traceback}
