"""Recipes: the parts of result keys that are known before a run.

The key of a result contains the contents of its inputs, which exist only after a run. A recipe omits them and lists the
other parts of the keys of all nodes: settings, edges, files, code. Equal recipes give equal keys.

State of results: their recipe at the time of measurement, compared with the current one.
"""

import sys
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import hairpipe
from hairpipe.app.api.cache import open_store
from hairpipe.app.api.formatting import shown
from hairpipe.app.api.selection import FrameSet, read_frames
from hairpipe.app.api.shot import Shot, WedgeShot
from hairpipe.engine.code import Code, CodeReader
from hairpipe.engine.file.overrides import parse_value
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.store.digest import digest
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.file import COST, Results, file_digest, read_results

PYTHON = f"{sys.version_info.major}.{sys.version_info.minor}"
SHORT = 16
"""Number of stored letters of a digest, which is only compared."""


@dataclass(frozen=True)
class Recipe:
    """The recipe of results.

    nodes    digests of type, settings, files and edges, by name of the node
    frames   digest of the frames of the run, frame rate, cuts and pre-roll
    modules  digests of first-party code, by name of the module
    python   version that parsed the code; the digests of other versions differ
    files    of the modules, in this installation
    """

    nodes: dict[str, str]
    frames: str
    modules: dict[str, str]
    python: str = PYTHON
    files: dict[str, Path] = field(default_factory=dict, compare=False)


def recipe_of(shot: Shot | WedgeShot, frames: FrameSet, to: Iterable[str]) -> Recipe:
    """Build the recipe of nodes of a shot, without writing files; BadInput if a file cannot be read.

    frames  of the run; None for all
    to      nodes, to which their dependencies are added
    """
    graph = shot.part(tuple(to))
    resolver = Resolver(graph, Store(shot.cache, read_only=True), graph.select(read_frames(frames)))
    nodes: dict[str, str] = {}
    for node in graph.nodes.values():
        edges = {plug: list(edge) for plug, edge in node.edges.items()}
        nodes[node.name] = digest("recipe", [node.type.name, resolver.settings[node.name], edges])[:SHORT]
    moments = digest("recipe", [list(resolver.frames), graph.fps, list(graph.cuts), graph.begin])[:SHORT]
    modules: dict[str, str] = {}
    for code in resolver.codes.values():
        modules |= modules_of(code)
    return Recipe(nodes, moments, modules, files=files_of(modules, resolver.reader))


def recipe_of_module(module: str) -> Recipe:
    """Build the recipe of a module without a graph; no file is written."""
    reader = CodeReader(open_store(read_only=True).remember)
    modules = modules_of(reader.code_of(module))
    return Recipe({}, "", modules, files=files_of(modules, reader))


def modules_of(code: Code) -> dict[str, str]:
    """Return the digests of first-party modules, without versions and the class of the processor."""
    return {name: part[:SHORT] for name, part in code.parts.items() if not name.endswith(")")}


def files_of(modules: Iterable[str], reader: CodeReader) -> dict[str, Path]:
    """Return the files of first-party modules."""
    return {module: Path(reader.file_of(module)) for module in modules}


CURRENT, OLDER, UNKNOWN = "current", "older code", "not compared"


@dataclass(frozen=True)
class State:
    """Changes since results were measured.

    word     CURRENT, OLDER, or UNKNOWN for code of another version of Python and a graph that cannot be loaded
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
