"""Edits that the page asks for, as edits of the text of its graph file, with undo and redo.

A stroke of a brush on a body writes a picture next to the graph, which a setting reads. A template is a shipped graph
as the beginning of another one, with copies of the files that it reads.
"""

import base64
from collections.abc import Callable
from difflib import unified_diff
from typing import Any, NamedTuple

import numpy as np

from hairpipe.app.api.draft import Draft
from hairpipe.app.api.shot import load
from hairpipe.app.api.source import shipped_graphs
from hairpipe.engine import edit as verbs
from hairpipe.engine.edit import literal_of, read_literal
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import encoded_image

MOST_PLACE = 1_000_000  # largest coordinate of a node on the page


def edited(draft: Draft, verb: str, given: dict[str, Any]) -> tuple[str, str]:
    """Return the text after an edit, and its description; KeyError for an unknown one, BadInput for a refused one."""
    return EDITS[verb](draft, given)


def set_value(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Set a setting to a text of TOML, or to another text as it is."""
    target = str(given["target"])
    text = toml_of(given["text"])
    verbs.check_node(draft.tables, target.partition(".")[0])
    return verbs.with_value(draft.text, target, text), f"{target} = {text}"


def unset_value(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Remove a setting or a group, which then has its default."""
    target = str(given["target"])
    verbs.check_node(draft.tables, target.partition(".")[0])
    return verbs.without_value(draft.text, target), f"{target} unset"


def switch(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Switch a group of settings on, with its defaults, or off: `false` where it is on by default."""
    target = str(given["target"])
    on = bool(given["on"])
    node, *names = target.split(".")
    field = draft.field(node, names)
    text = verbs.without_value(draft.text, target) if given_at(draft, node, names) is not None else draft.text
    if on and field.default is None:
        text = verbs.with_value(text, target, "{}")
    elif not on and field.default is not None:
        text = verbs.with_value(text, target, "false")
    return text, f"{target} {'on' if on else 'off'}"


def add(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Add a node of a type at a place; `edges` by socket, `feeds` is an input that takes its output."""
    kind = str(given["type"])
    name = verbs.free_name([*draft.tables, *draft.layout], kind.rpartition("_")[2])
    edges = {str(socket): str(source) for socket, source in given.get("edges", {}).items()}
    text = verbs.with_node(draft.text, name, kind, edges)
    if "feeds" in given:
        text = connected(text, str(given["feeds"]["node"]), str(given["feeds"]["socket"]), name, draft)
    return placed(text, {name: given["at"]} if "at" in given else {}), f"add {name}"


def remove(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    names = [str(name) for name in given["nodes"]]
    return verbs.without_nodes(draft.text, names), f"delete {', '.join(names)}"


def connect(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    node, socket, source = str(given["node"]), str(given["socket"]), str(given["source"])
    text = connected(draft.text, node, socket, source, draft)
    return text, f"{node}.in.{socket} = {source}"


def disconnect(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Cut an edge by its plug, `socket` or `socket.0`."""
    node, plug = str(given["node"]), str(given["plug"])
    socket, _, number = plug.partition(".")
    target = f"{node}.in.{socket}"
    sources = given_at(draft, node, ["in", socket])
    kept = list[Any]()
    if number and isinstance(sources, list):
        kept = [one for place, one in enumerate(sources) if place != int(number)]
    text = verbs.with_value(draft.text, target, literal_of(kept)) if kept else verbs.without_value(draft.text, target)
    return text, f"{node}.in.{plug} cut"


def rename(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    old, new = str(given["node"]), str(given["name"])
    return verbs.renamed(draft.text, old, new), f"rename {old} to {new}"


def mute(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Pass nodes by, or do not."""
    text = draft.text
    names = [str(name) for name in given["nodes"]]
    on = bool(given["on"])
    for name in names:
        verbs.check_node(draft.tables, name)
        text = verbs.with_value(text, f"{name}.mute", "true") if on else verbs.without_value(text, f"{name}.mute")
    return text, f"{'mute' if on else 'unmute'} {', '.join(names)}"


def duplicate(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Copy nodes, at places by name; with `like`, copies state only what differs."""
    text = draft.text
    names = [str(name) for name in given["nodes"]]
    places = dict[str, Any]()
    for name in names:
        copy = verbs.free_name([*draft.tables, *draft.layout, *places], name.rstrip("0123456789").rstrip("_"))
        text = verbs.duplicated(text, name, copy, like=bool(given.get("like")))
        places[copy] = given.get("at", {}).get(name)
    return placed(text, places), f"duplicate {', '.join(names)}"


def paste(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Add nodes from a text of TOML, at places by their names there."""
    text, names = verbs.pasted(draft.text, str(given["text"]))
    places = {names[name]: place for name, place in given.get("at", {}).items() if name in names}
    return placed(text, places), f"paste {', '.join(names.values())}"


def annotate(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Set a frame of the page, `title` and `nodes`, or a note, `text` and `at`; None removes one."""
    value = given["value"]
    kind = "frame" if value and "nodes" in value else "note"
    name = str(given.get("name") or verbs.free_name([*draft.tables, *draft.layout], kind))
    if name in draft.tables:
        raise BadInput(f"'{name[:60]}' is a node", right="a name of its own")
    return verbs.placed(draft.text, {name: value}), f"{name} {'set' if value else 'removed'}"


def shot(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Set frames, frame rate or preroll of the shot to a text of TOML."""
    name = str(given["name"])
    literal = toml_of(given["text"])
    if name not in ("frames", "fps", "preroll"):
        raise BadInput(f"no setting '{name[:60]}' of the shot", right="frames, fps or preroll")
    return verbs.with_header(draft.text, name, literal), f"{name} = {literal[:60]}"


def template(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Begin an empty graph with the text of a shipped one, which then publishes below its own folder."""
    name = str(given["name"])
    if draft.tables or name not in shipped_graphs():
        raise BadInput(f"'{name[:60]}' is not a template", right="an empty graph, and the name of a shipped one")
    text = shipped_graphs()[name].read_text(encoding="utf-8").replace('publish = "../', 'publish = "')
    copied = [f"{file} copied next to the graph" for file in given.get("files", [])]
    return text, "; ".join([f"begin with {name}", *map(str, copied)])


def move(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    for name in given["positions"]:
        verbs.check_node(draft.tables, name)
    return placed(draft.text, given["positions"]), f"move {', '.join(given['positions'])[:60]}"


def paint(draft: Draft, given: dict[str, Any]) -> tuple[str, str]:
    """Let a setting read a picture, in place of a map."""
    target = str(given["target"])
    text = draft.text
    if "map" in painted_group(draft, target):
        text = verbs.without_value(text, f"{target}.map")
    return verbs.with_value(text, f"{target}.image", literal_of(str(given["file"]))), f"paint {target}"


def painted_group(draft: Draft, target: str) -> dict[str, Any]:
    """Return the given values of a setting that reads maps and pictures; BadInput for another one."""
    node, *names = target.split(".")
    if not {"map", "image"} <= {field.name for field in draft.field(node, names).group}:
        raise BadInput("not painted", where=target[:80], right="a setting with a map and an image")
    given = given_at(draft, node, names)
    return given if isinstance(given, dict) else {}


EDITS = {
    "edit": set_value,
    **{f.__name__: f for f in (switch, add, remove, connect, disconnect, rename, mute, duplicate, move)},
    **{f.__name__: f for f in (paste, annotate, shot, paint, template)},
    "unset": unset_value,
}
"""Edits by the name of their request."""


def toml_of(given: Any) -> str:
    """Return a text that is a value of TOML, or write another one as a text of TOML."""
    text = str(given).strip()
    try:
        read_literal(text)
    except (ValueError, RecursionError):
        return literal_of(text)
    return text


def connected(text: str, node: str, socket: str, source: str, draft: Draft) -> str:
    """Return a text with an input connected."""
    verbs.check_node(draft.tables, node)
    found = draft.types[node].sockets.get(socket)
    others = given_at(draft, node, ["in", socket])
    value: str | list[str] = source
    if found is not None and found.many and others is not None:
        value = [*(others if isinstance(others, list) else [others]), source]
    return verbs.with_value(text, f"{node}.in.{socket}", literal_of(value))


def placed(text: str, places: dict[str, Any]) -> str:
    """Return a text with positions of nodes, None for no position; ValueError for coordinates that no page has."""
    if any(abs(x) > MOST_PLACE for place in places.values() if place for x in place):
        raise ValueError("too far")
    return verbs.placed(text, {name: place and [round(x) for x in place] for name, place in places.items()})


def given_at(draft: Draft, node: str, names: list[str]) -> Any:
    """Return a value in the table of a node, with that of the node that it is like; None for an absent one."""
    table: Any = draft.tables.get(node)
    for name in names:
        table = table.get(name) if isinstance(table, dict) else None
    return table


FOLDER = "paint"  # folder of the pictures, next to the graph file


def write_stroke(draft: Draft, given: dict[str, Any]) -> str:
    """Write the picture of a request into a new file; return its path from the graph.

    ValueError for values that are not those of a picture; BadInput for a setting that reads none, and as `write_new`.
    """
    target = str(given["target"])
    painted_group(draft, target)
    values = np.frombuffer(base64.b64decode(given["values"], validate=True), np.uint8)
    data = encoded_image(values.reshape(int(given["height"]), -1))
    name = target.replace(".", "_")
    numbers = [path.stem.rpartition("_")[2] for path in (draft.shot.path.parent / FOLDER).glob(f"{name}_*.png")]
    number = 1 + max((int(found) for found in numbers if found.isdecimal()), default=0)
    return draft.write_new(f"{FOLDER}/{name}_{number}.png", data)


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


MOST_STEPS = 500  # maximum number of edits that can be undone

Deed = tuple[str, dict[str, Any]]


class Edit(NamedTuple):
    """Text of a graph after an edit.

    deed  verb and values of the edit, to repeat it in another text; None for a change by another program
    """

    label: str  # description of the edit
    text: str
    deed: Deed | None = None


class History:
    """Texts of a graph, of which one is the present.

    at      number of the present text
    disk    text of the file as last read or written; None for a file that does not exist
    theirs  text of the file, which another program has changed while there were unsaved edits; else None
    """

    def __init__(self, text: str, disk: str | None) -> None:
        self._steps = [Edit("", text)]
        self._saved = 0
        self.at = 0
        self.disk = disk
        self.theirs: str | None = None

    @property
    def text(self) -> str:
        """The present text."""
        return self._steps[self.at].text

    @property
    def first(self) -> str:
        """The earliest text that is kept."""
        return self._steps[0].text

    def push(self, step: Edit) -> None:
        """Add an edit after the present text; texts that were undone are lost."""
        self._steps = [*self._steps[: self.at + 1], step][-MOST_STEPS:]
        self._saved = self._saved - max(0, self.at + 2 - MOST_STEPS) if self._saved <= self.at else -1
        self.at = len(self._steps) - 1

    def seek(self, by: int) -> str:
        """Return the text of an earlier edit, or of one that was undone; BadInput if there is none."""
        if not 0 <= self.at + by < len(self._steps):
            raise BadInput("nothing to undo" if by < 0 else "nothing to redo")
        return self._steps[self.at + by].text

    def written(self, text: str) -> None:
        """Note that the file has the present text."""
        self.disk, self.theirs, self._saved = text, None, self.at

    def deeds(self) -> list[Edit]:
        """List the edits since the file was saved."""
        return self._steps[self._saved + 1 : self.at + 1] if self._saved >= 0 else self._steps[1 : self.at + 1]

    def repeated(self, edit: Callable[[str, Deed], str]) -> str:
        """Return the text of the other program with the unsaved edits repeated in it; BadInput where one cannot be."""
        text = self.text if self.theirs is None else self.theirs
        for step in self.deeds():
            text = edit(text, step.deed) if step.deed else text
        return text

    def document(self) -> dict[str, Any]:
        """Describe the unsaved edits, how far one can go back and forth, and a conflict as differences of lines."""
        labels = {str(step.deed and step.deed[1].get("target", step)): step.label for step in self.deeds()}
        undone = [f"undone: {step.label}" for step in self._steps[self.at + 1 : self._saved + 1]]
        sides = self.text.splitlines(), (self.theirs or "").splitlines()
        difference = unified_diff(*sides, "this page", "the file", lineterm="", n=1)
        return {
            "edits": [*labels.values(), *undone] or (["a new file"] if self.disk is None else []),
            "undo": self._steps[self.at].label if self.at else None,
            "redo": self._steps[self.at + 1].label if self.at + 1 < len(self._steps) else None,
            "conflict": None if self.theirs is None else list(difference),
        }
