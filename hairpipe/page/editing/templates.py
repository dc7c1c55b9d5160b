"""Templates: a shipped graph as the beginning of another one, with copies of the files that it reads."""

from hairpipe.api.draft import Draft
from hairpipe.api.shot import load
from hairpipe.errors import BadInput


def copy_assets(draft: Draft, name: str) -> list[str]:
    """Copy the files that a shipped graph reads next to another graph; return the paths of new ones from there.

    Files that are there already, with the same bytes, stay. BadInput for other bytes, and as `write_new`.
    """
    graph = load(name).graph
    home = graph.path.resolve().parent
    copied = []
    for path in graph.files:
        given = path.relative_to(home).as_posix()
        there = draft.shot.path.parent / given
        if path == graph.path.resolve() or (there.is_file() and there.read_bytes() == path.read_bytes()):
            continue
        if there.exists():
            raise BadInput(f"another file than that of '{name}'", where=there, right="a graph in another folder")
        copied.append(draft.write_new(given, path.read_bytes()))
    return copied
