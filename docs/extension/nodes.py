"""`{nodes} PURPOSE`: the node types of a purpose, with inputs, outputs, settings and an example of each."""

import inspect
import json
from collections.abc import Iterator

from sphinx.application import Sphinx

from extension.examples import example_of
from extension.markdown import MarkdownDirective, blocks_of, docstring, escaped, fence, joined, table
from extension.purposes import purpose_of
from hairpipe.app.api.node_types import Field, NodeType, Socket, fields_of, fields_within, node_types

MODES = {
    "once": "One value for the shot.",
    "each": "One value per frame.",
    "scan": "One value per frame, from the previous frame.",
}
VIEWS = {
    "now": "this frame",
    "pair": "previous and this frame",
    "frames": "all frames",
    "reached": "all frames that were reached",
}


class Nodes(MarkdownDirective):
    """The node types of a purpose, in alphabetical order."""

    labelled = True

    def write(self) -> str:
        """Describe every node type of the purpose."""
        catalogue = node_types()
        known = [catalogue.find(name) for name in catalogue.names()]
        return joined(describe(each) for each in known if purpose_of(each) == " ".join(self.arguments))


def describe(node_type: NodeType) -> str:
    """Describe a node type, below a heading of its name."""
    source, example = example_of(node_type)
    words = blocks_of(inspect.getdoc(inspect.unwrap(node_type.function)) or "")[1:]  # without those of shared groups
    more = [docstring("\n".join(lines)) for lines in words if not explains(lines, node_type)]
    settings = [row for field in fields_of(node_type) for row in rows_of(field, "")]
    return joined(
        [
            f"## {escaped(node_type.name)}",
            f"{escaped(node_type.summary)} {MODES[node_type.mode]}",
            *more,
            table(["input", "type", "reads"], [input_row(socket) for socket in node_type.sockets.values()]),
            f"Output: {', '.join(output_words(node_type, name) for name in node_type.outputs)}.",
            table(["setting", "default", "allowed", "meaning"], settings),
            fence("toml", example),
            f"From `{source}`." if source else "",
        ]
    )


def output_words(node_type: NodeType, name: str) -> str:
    """Describe an output, which has no name where there is one only; of a file, with its suffixes."""
    kind = node_type.outputs[name].__name__
    suffixes = f"({', '.join(node_type.writes)})" * (kind == "File")
    return " ".join(filter(None, [f"`{name}`" * bool(name), type_link(kind), suffixes]))


def type_link(name: str) -> str:
    """Link the type of a value to its description, where it has one."""
    import hairpipe.values

    return f"{{ref}}`{name} <value-{name}>`" if name in hairpipe.values.__all__ else name


def explains(lines: list[str], node_type: NodeType) -> bool:
    """Whether a paragraph of a docstring is the list of settings."""
    return lines[0].split()[0] in {field.name for field in fields_of(node_type)} and "  " in lines[0].strip()


def input_row(socket: Socket) -> list[str]:
    """Describe an input."""
    words = [VIEWS[socket.view], "any number of edges" * socket.many, "optional" * socket.optional]
    return [f"`{socket.name}`", type_link(socket.type.__name__), ", ".join(filter(None, words))]


def rows_of(field: Field, prefix: str) -> Iterator[list[str]]:
    """Describe a setting, and after a group its fields."""
    allowed = ", ".join(filter(None, [field.kind + unit_of(field), field.range]))
    yield [f"`{prefix}{field.name}`", default_of(field), escaped(allowed), escaped(field.help)]
    for inner in fields_within(field):
        yield from rows_of(inner, f"{prefix}{field.name}.")


def unit_of(field: Field) -> str:
    """Return the unit with a word before it; empty where there is none."""
    return f" in {field.unit}" if field.unit not in (None, "1") else ""


def default_of(field: Field) -> str:
    """Return the default as a graph file would state it."""
    if field.required:
        return "required"
    if field.default is None:
        return "absent"
    return "" if field.group else f"`{json.dumps(field.default, default=str)}`"


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("nodes", Nodes)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
