"""Files that hairpipe reads: hair as USD text, surfaces as binary PLY. A file with the same content is left alone."""

import os
from pathlib import Path

import numpy as np

from .scene import Faces, Hair

EIGHTHS = 8
"""Places of pins along a strand: parts of its length from the root."""


def write(path: Path, content: bytes) -> None:
    """Write a file as a whole, if its content differs. OSError where it cannot be written."""
    if path.is_file() and path.stat().st_size == len(content) and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    part.write_bytes(content)
    part.replace(path)


def ply_of(faces: Faces) -> bytes:
    """Return a surface as a binary PLY file: vertices in double precision, polygons as they are."""
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(faces.points)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(faces.sizes)}\nproperty list int int vertex_indices\nend_header\n"
    )
    begins = np.cumsum(faces.sizes) - faces.sizes
    rows = np.insert(faces.corners.astype("<i4"), begins, faces.sizes.astype("<i4"))
    return header.encode() + faces.points.astype("<f8").tobytes() + rows.tobytes()


def usd_of(hair: Hair, groups: list[str]) -> bytes:
    """Return curves as USD text, with ids, widths, texture coordinates, maps, and the group of each curve, if any."""
    maps = "".join(uniform("float", name, digits(values)) for name, values in sorted(hair.maps.items()))
    uv = "" if hair.uv is None else uniform("texCoord2f", "st", tuples(hair.uv))
    names = uniform("string", "groom_group_name", ", ".join(f'"{name}"' for name in groups)) if groups else ""
    return f"""#usda 1.0
(
    defaultPrim = "hair"
    metersPerUnit = 1
    upAxis = "Y"
)
def BasisCurves "hair"
{{
    uniform token type = "cubic"
    uniform token basis = "catmullRom"
    uniform token wrap = "pinned"
    int[] curveVertexCounts = [{", ".join(map(str, hair.sizes.tolist()))}]
    point3f[] points = [{tuples(hair.points)}]
    float[] widths = [{digits(2.0 * hair.radii)}] (interpolation = "vertex")
{uniform("int", "id", ", ".join(map(str, hair.ids.tolist())))}{uv}{names}{maps}}}
""".encode()


def uniform(kind: str, name: str, values: str) -> str:
    """Return a primvar with a value for each curve; letters that USD does not allow become _."""
    allowed = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in name)
    allowed = allowed if allowed[:1].isalpha() or allowed[:1] == "_" else f"_{allowed}"
    return f'    uniform {kind}[] primvars:{allowed} = [{values}] (interpolation = "uniform")\n'


def digits(values: np.ndarray) -> str:
    return ", ".join(map("{:.9g}".format, values.tolist()))


def tuples(rows: np.ndarray) -> str:
    form = f"({', '.join(['%.9g'] * rows.shape[1])})"
    return ", ".join(form % tuple(row) for row in rows.tolist())


def pin_places(hair: Hair) -> tuple[list[str], dict[str, list[float]]]:
    """Return the group of each curve, and where the curves of a group are pinned, in parts of their length.

    Curves with pins at the same eighths of their length are a group; those without pins are the group "free". Without
    pins there are neither.
    """
    if hair.pinned is None:
        return [], {}
    groups: list[str] = []
    places: dict[str, list[float]] = {}
    begin = 0
    for size in hair.sizes.tolist():
        points, pinned = hair.points[begin : begin + size], hair.pinned[begin : begin + size]
        begin += size
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
        eighths = sorted({round(EIGHTHS * at) for at in (along[pinned] / along[-1]).tolist()})
        name = "pins_" + "".join(map(str, eighths)) if eighths else "free"
        groups.append(name)
        if eighths:
            places[name] = [eighth / EIGHTHS for eighth in eighths]
    return (groups, places) if places else ([], {})
