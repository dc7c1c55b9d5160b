"""Recipes: the parts of result keys that are known before a run.

The key of a result contains the contents of its inputs, which exist only after a run. A recipe omits them and lists the
other parts of the keys of all nodes: settings, edges, files, code. Equal recipes give equal keys.
"""

import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from hairpipe.api.cache import open_store
from hairpipe.api.selection import FrameSet, read_frames
from hairpipe.api.shot import Shot
from hairpipe.api.wedge_shot import WedgeShot
from hairpipe.graph.key.code import Code, CodeReader
from hairpipe.graph.plan.resolve import Resolver
from hairpipe.graph.store.digest import digest
from hairpipe.graph.store.store import Store

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
