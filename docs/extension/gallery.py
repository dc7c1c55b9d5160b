"""`{gallery} FOLDER`: cards of the graphs of a folder: film or picture, opening comment, command, cost."""

from pathlib import Path
from typing import ClassVar

from docutils.parsers.rst import directives
from sphinx.application import Sphinx

from extension.films import HOME, Film, films, measured
from extension.markdown import MarkdownDirective, joined
from hairpipe.graphs.experiments.figures.recipe import state_of

PICTURES = HOME / "graphs/assets/pictures"


class Gallery(MarkdownDirective):
    """The graphs of a folder below `graphs/`, or without a name of `graphs/` itself.

    A graph shows its film, or else the picture of its name; a line `graph  path` names another one. With `:moving:`
    only graphs with a film have a card.
    """

    option_spec: ClassVar = {"moving": directives.flag}

    def write(self) -> str:
        """Write the cards."""
        folder = HOME / "graphs" / " ".join(self.arguments)
        others = dict(line.split() for line in self.content if line)
        paths = [path for path in sorted(folder.glob("*.toml")) if "moving" not in self.options or film_of(path)]
        if unknown := others.keys() - {path.stem for path in paths}:
            raise self.error(f"no graph of this name in {folder.name}: {', '.join(sorted(unknown))}")
        return joined(self.card(path, HOME / others.get(path.stem, PICTURES / f"{path.stem}.webp")) for path in paths)

    def card(self, path: Path, picture: Path) -> str:
        """Write the card of a graph."""
        name = name_of(path)
        film = film_of(path)
        still = f"![{name}](/../{picture.relative_to(HOME).as_posix()})" if picture.is_file() else ""
        shown = f"![Film of {name}](/films/{film.graph}.webp)" if film else still
        cost = [cost_of(film)] if film else []
        return joined([f"### {name}", shown, opening_of(path), f"    hairpipe run {name}", *cost])


def name_of(path: Path) -> str:
    """Return the name of a graph, by which `hairpipe run` finds it: `paper/long_curly`."""
    return path.relative_to(HOME / "graphs").with_suffix("").as_posix()


def film_of(path: Path) -> Film | None:
    """Find the film of a graph; None where it was not made."""
    film = films().get(name_of(path))
    return film if film and film.path.is_file() else None


def cost_of(film: Film) -> str:
    """Write what the film took when it was recorded."""
    results, values = measured(film)
    made = f"commit {results.commit[:7]}, {state_of(film.results_path).word}"
    return f"Film: {values['pictures']} pictures, {values['processor']:.0f} s of the processor ({made})"


def opening_of(path: Path) -> str:
    """Return the comment that a graph begins with."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# "))
    return " ".join(lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("gallery", Gallery)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
