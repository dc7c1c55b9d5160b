"""State of results: their recipe at the time of measurement, compared with the current one."""

from dataclasses import dataclass, replace
from pathlib import Path

import hairpipe
from hairpipe.api.formatting import shown
from hairpipe.errors import BadInput
from hairpipe.graph.file.overrides import parse_value
from hairpipe.results.file import COST, Results, file_digest, read_results
from hairpipe.results.recipe import Recipe, recipe_of, recipe_of_module

CURRENT, OLDER, UNKNOWN = "current", "older code", "not compared"
WORDS = (CURRENT, OLDER, UNKNOWN)


@dataclass(frozen=True)
class State:
    """Changes since results were measured.

    word     one of WORDS: code of another version of Python, and a graph that cannot be loaded, are not compared
    changed  files of code, nodes of the graph in brackets, or why they were not compared
    """

    path: Path
    results: Results
    word: str
    changed: tuple[str, ...]


def state_of(path: Path) -> State:
    """Compare results with the code and the graph of this installation; BadInput if the file is damaged."""
    results = read_results(path)
    try:
        recipe = recipe_now(path, results)
    except BadInput as fault:
        return State(path, results, UNKNOWN, (str(fault),))
    if recipe.python != results.python:
        return State(path, results, UNKNOWN, (f"Python {results.python} -> {recipe.python}",))
    changed = changes(results, recipe)
    return State(path, results, OLDER if changed else CURRENT, changed)


def recipe_now(path: Path, results: Results) -> Recipe:
    """Build the current recipe of the tables of a results file; BadInput if the graph no longer has them."""
    if results.graph is None:
        files = {name: file_digest(path.parent.parent / name) for name in results.nodes}
        return replace(recipe_of_module(results.module), nodes=files)
    settings = {target: parse_value(text) for target, text in results.settings.items()}
    shot = hairpipe.load(path.parent.parent / results.graph, settings)
    nodes = results.to or [name for name in results.tables if name != COST]
    return recipe_of(shot.wedge(results.wedge) if results.wedge else shot, results.frames, nodes)


def changes(results: Results, now: Recipe) -> tuple[str, ...]:
    """List the differences: files of code, then nodes, then the frames of the run."""
    modules = differing(results.modules, now.modules)
    files = [shown(now.files[module]) if module in now.files else f"{module} (no longer used)" for module in modules]
    nodes = [f"[{name}]" for name in differing(results.nodes, now.nodes)]
    return (*files, *nodes, *(["frames"] if results.shot != now.frames else []))


def differing(old: dict[str, str], new: dict[str, str]) -> list[str]:
    """List the names whose digests differ, in order."""
    return sorted(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
