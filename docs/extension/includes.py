"""Pages of the repository that these pages include: a link in them leads to the same target from here."""

import os
import re
from pathlib import Path

from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parents[1]
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")


def redirected(match: re.Match[str], source: Path) -> str:
    """Write a link of an included file so that it leads to the same thing from any page; a folder is only named."""
    mark, text, target = match.groups()
    if "://" in target or target.startswith("#"):
        return match[0]
    name, hash_sign, anchor = target.partition("#")
    path = (source.parent / name).resolve()
    if path.is_dir():
        return text
    return f"{mark}[{text}](/{Path(os.path.relpath(path, DOCS)).as_posix()}{hash_sign}{anchor})"


def redirect(app: Sphinx, relative_path: Path, parent_docname: str, content: list[str]) -> None:
    """Redirect all links of a file that is being included, in place."""
    source = (DOCS / relative_path).resolve()
    content[0] = LINK.sub(lambda match: redirected(match, source), content[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Follow what is included."""
    app.connect("include-read", redirect)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
