"""`{gallery} FOLDER`: a card for every graph of a folder: its picture, its opening comment, and its command."""

from pathlib import Path

from sphinx.application import Sphinx

from extension.markdown import MarkdownDirective, joined

HOME = Path(__file__).resolve().parents[2]
PICTURES = HOME / "graphs/assets/pictures"


class Gallery(MarkdownDirective):
    """The graphs of a folder below `graphs/`, or without a name of `graphs/` itself.

    A graph shows the picture of its name; a line `graph  path` names another one.
    """

    def write(self) -> str:
        """Write the cards."""
        folder = HOME / "graphs" / " ".join(self.arguments)
        others = dict(line.split() for line in self.content if line)
        paths = sorted(folder.glob("*.toml"))
        if unknown := others.keys() - {path.stem for path in paths}:
            raise self.error(f"no graph of this name in {folder.name}: {', '.join(sorted(unknown))}")
        return joined(self.card(path, HOME / others.get(path.stem, PICTURES / f"{path.stem}.webp")) for path in paths)

    def card(self, path: Path, picture: Path) -> str:
        """Write the card of a graph."""
        name = path.relative_to(HOME / "graphs").with_suffix("").as_posix()
        shown = f"![{name}](/../{picture.relative_to(HOME).as_posix()})" if picture.is_file() else ""
        return joined([f"### {name}", shown, opening_of(path), f"    hairpipe run graphs/{name}.toml"])


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
