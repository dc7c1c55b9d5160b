"""Documents of a value by its type."""

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hairpipe.data import Body, Cloud, Density, Groom, LevelSet, Mesh, Particles, PointValues, Strands, Table
from hairpipe.data.hair import HairState
from hairpipe.graph import File
from hairpipe.page import shapes
from hairpipe.page.packing import Packed

MEDIA = {
    b"\x89PNG": ".png",
    b"\xff\xd8\xff": ".jpg",
    b"RIFF": ".webp",
    b"<svg": ".svg",
    b"<?xml": ".svg",
}
"""Suffixes of pictures, by their first bytes."""
TYPES = {".png": "image/png", ".jpg": "image/jpeg", ".webp": "image/webp", ".svg": "image/svg+xml"}
KINDS: dict[type, tuple[str, ...]] = {
    Strands: ("strands",),
    Groom: ("strands", "maps"),
    Mesh: ("mesh",),
    Body: ("mesh", "maps"),
    LevelSet: ("slices", "surface"),
    Density: ("slices",),
    Cloud: ("points",),
    Particles: ("points",),
    Table: ("table",),
    PointValues: ("values",),
    HairState: ("value", "contacts"),
}
"""Documents of values by their type; other types have `value`, a summary."""


def kinds_of(kind: type) -> tuple[str, ...]:
    """List the documents of a value of a type; none for a file, which a browser may show itself."""
    return () if kind is File else KINDS.get(kind, ("value",))


def suffix_of(path: Path) -> str | None:
    """Return the suffix of a picture by its bytes, independent of its name; None for other or missing files."""
    try:
        with path.open("rb") as file:
            head = file.read(8)
    except OSError:
        return None
    return next((suffix for mark, suffix in MEDIA.items() if head.startswith(mark)), None)


def mesh_of(kind: str, value: Any) -> Mesh | None:
    """Return the mesh that a document of a value describes; None for a document without triangles."""
    if kind == "surface":
        return shapes.surface_of(value)
    if kind != "mesh":
        return None
    return value.mesh if isinstance(value, Body) else value


def document_of(kind: str, value: Any, most: int) -> Packed:
    """Describe a value in one document; `shapes` describes meshes, which have two.

    most  maximum number of shown strands
    """
    make: dict[str, Callable[[], Packed]] = {
        "strands": lambda: shapes.strands_document(value, most),
        "points": lambda: shapes.points_document(value),
        "values": lambda: shapes.values_document(value, most),
        "contacts": lambda: shapes.contacts_document(value),
        "slices": lambda: shapes.slices_document(value),
        "table": lambda: (table_document(value), b""),
        "maps": lambda: shapes.maps_document(value),
        "value": lambda: ({"lines": list(summary_lines(value))}, b""),
    }
    return make[kind]()


def table_document(table: Table) -> dict[str, Any]:
    """Describe a table; a number that is not finite is a text."""
    return {"names": list(table.names), "rows": [[plain(cell) for cell in row] for row in table.rows()]}


def plain(cell: Any) -> Any:
    """Return a number of JSON, or a text."""
    return str(cell) if isinstance(cell, float) and not math.isfinite(cell) else cell


def summary_lines(value: Any, prefix: str = "") -> list[list[str]]:
    """List the arrays and numbers in a value: name, shape and type, least and largest."""
    if isinstance(value, np.ndarray):
        numbers = value[np.isfinite(value)] if value.dtype.kind == "f" else value
        spread = f"{numbers.min():.6g} ... {numbers.max():.6g}" if numbers.size and numbers.dtype.kind in "iufb" else ""
        return [[prefix, f"{' x '.join(map(str, value.shape))} {value.dtype}", spread]]
    if dataclasses.is_dataclass(value) or (isinstance(value, tuple) and hasattr(value, "_fields")):
        names = getattr(value, "_fields", None) or [field.name for field in dataclasses.fields(value)]  # type: ignore[arg-type]
        return [line for name in names for line in summary_lines(getattr(value, name), f"{prefix}.{name}".lstrip("."))]
    if isinstance(value, dict):
        return [line for name, inner in value.items() for line in summary_lines(inner, f"{prefix}[{name}]")]
    return [[prefix, type(value).__name__, str(value)[:200]]]
