"""The films of the gallery: what `docs/films/films.toml` lists, and what `make film` has recorded of each."""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from hairpipe.graphs.experiments.figures.file import COST, Results, read_results, results_path

HOME = Path(__file__).resolve().parents[2]
FILMS = HOME / "docs/films"


@dataclass(frozen=True)
class Film:
    """A film of a graph: the pictures of one of its nodes.

    graph     name below `graphs/`, as in `paper/long_curly`
    picture   node of the pictures
    frames    frames of the run
    settings  assignments `NODE.SETTING=VALUE`, which keep run and film small
    """

    graph: str
    picture: str
    frames: str
    settings: tuple[str, ...]

    @property
    def path(self) -> Path:
        """Path of the film."""
        return FILMS / f"{self.graph}.webp"

    @property
    def results_path(self) -> Path:
        """Path of the results of its run."""
        return results_path(FILMS, self.graph)

    @property
    def command(self) -> str:
        """Command that makes the film again."""
        return f"make film GRAPH={self.graph}"


@cache
def films() -> dict[str, Film]:
    """Return all films by name of the graph."""
    listed = tomllib.loads((FILMS / "films.toml").read_text(encoding="utf-8"))
    return {name: Film(name, film["picture"], film["frames"], tuple(film["set"])) for name, film in listed.items()}


def measured(film: Film) -> tuple[Results, dict[str, float]]:
    """Read the results of the run of a film, and its cost: number of pictures, seconds of the processor, megabytes."""
    results = read_results(film.results_path)
    table = results.tables[COST]
    nodes: dict[Any, dict[str, Any]] = {row[0]: dict(zip(table.columns, row, strict=True)) for row in table.rows}
    sums = {name: sum(node[name] for node in nodes.values()) for name in ("processor", "size [MB]")}
    return results, {"pictures": nodes[film.picture]["results"], **sums}
