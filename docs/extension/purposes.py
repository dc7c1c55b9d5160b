"""What node types are for, as their outputs say it: the pages of the reference are sorted by it."""

from hairpipe.app.api.node_types import NodeType

PURPOSES = {
    "groom": {"Groom", "Ends", "Pins"},
    "body": {"Body", "Mesh", "Pose"},
    "level set": {"BodyParts", "Density", "LevelSet"},
    "simulate": {"Cloud", "Normals", "Particles", "Strands"},
    "measure": {"PointValues", "Table"},
    "export": {"File"},
    "render": {"File"},
}
"""Types of the first output, by purpose; a file belongs to `render` if it is a picture."""
PICTURES = {".png", ".webp"}


def purpose_of(node_type: NodeType) -> str:
    """Return the purpose of a node type; LookupError for an output that no purpose has."""
    kind = next(iter(node_type.outputs.values())).__name__
    found = [purpose for purpose, kinds in PURPOSES.items() if kind in kinds]
    if kind == "File":
        return "render" if PICTURES & set(node_type.writes) else "export"
    if not found:
        raise LookupError(f"docs/extension/purposes.py: no purpose for a node with output {kind}: {node_type.name}")
    return found[0]
