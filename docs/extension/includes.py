"""Pages of the repository that these pages include: links in them lead where the target is shown here.

A README lies next to the code that it describes, and its links are relative to itself. Here a link to a README, or to a
section of one, leads to the page that includes it; a link to another file offers that file; a folder is only named.
"""

import os
import re
from functools import cache
from pathlib import Path

from sphinx.application import Sphinx

DOCS = Path(__file__).resolve().parents[1]
INCLUDE = re.compile(r"^:::\{include\} (\S+)\n((?::[\w-]+: .*\n)*):::$", re.MULTILINE)
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


def slug_of(heading: str) -> str:
    """Return the anchor of a heading."""
    return re.sub(r"[^\w -]", "", heading).strip().lower().replace(" ", "-")


def included_part(path: Path, options: str) -> str:
    """Return the part of a file that an include with these options takes."""
    text = path.read_text(encoding="utf-8")
    for name, value in re.findall(r"^:([\w-]+): (.*)$", options, re.MULTILINE):
        if name == "start-after":
            text = text.partition(value)[2]
        elif name == "end-before":
            text = text.partition(value)[0]
    return text


@cache
def places() -> dict[Path, dict[str, str]]:
    """Return, for every included file, the page that shows each of its anchors; under the empty one, the first page."""
    found: dict[Path, dict[str, str]] = {}
    for page in sorted(DOCS.rglob("*.md")):
        for target, options in INCLUDE.findall(page.read_text(encoding="utf-8")):
            path = (page.parent / target).resolve()
            name = "/" + page.relative_to(DOCS).as_posix()
            anchors = {slug_of(heading): name for heading in HEADING.findall(included_part(path, options))}
            found[path] = {"": name, **anchors} | found.get(path, {})
    return found


def redirected(match: re.Match[str], source: Path) -> str:
    """Write a link of an included file so that it leads to the same thing from any page."""
    mark, text, target = match.groups()
    if "://" in target:
        return match[0]
    name, _, anchor = target.partition("#")
    path = (source.parent / name).resolve() if name else source
    shown = places().get(path)
    if shown and not mark:
        return f"[{text}]({shown.get(anchor, shown[''])}{f'#{anchor}' * (anchor in shown)})"
    if path.is_dir():
        return text
    return f"{mark}[{text}](/{Path(os.path.relpath(path, DOCS)).as_posix()})"


def redirect(app: Sphinx, relative_path: Path, parent_docname: str, content: list[str]) -> None:
    """Redirect all links of a file that is being included, in place."""
    source = (DOCS / relative_path).resolve()
    content[0] = LINK.sub(lambda match: redirected(match, source), content[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Follow what is included."""
    app.connect("include-read", redirect)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
