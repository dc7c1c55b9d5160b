"""A coarse bust with skin, a morph target of the jaw, and two clips. Running it writes nod.glb."""

import json
from functools import partial
from pathlib import Path

import numpy as np

from hairpipe.body import bust
from hairpipe.body.anatomy import BUST
from hairpipe.body.blended_shapes import evaluate, project
from hairpipe.body.bust import relax
from hairpipe.body.scalp import height_above
from hairpipe.geometry.isosurface import extract_surface

COARSE = 1.9  # spacing of the samples over that of `make_bust`
JAW = (0.0, 0.265, 0.09)  # [m]
KEYS = np.linspace(0.0, 2.0, 17)  # of the clips [s]
CODES = {"float32": 5126, "uint16": 5123, "uint8": 5121}


class Glb:
    """Accessors of a file in one buffer."""

    def __init__(self) -> None:
        self.data = b""
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, object]] = []

    def add(self, values: np.ndarray, kind: str, **more: object) -> int:
        """Append an array; return the index of its accessor."""
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.tobytes() + bytes(-values.nbytes % 4)
        accessor = {"bufferView": len(self.views) - 1, "componentType": CODES[values.dtype.name], "type": kind}
        self.accessors.append(accessor | {"count": len(values)} | more)
        return len(self.accessors) - 1

    def write(self, path: Path, **content: object) -> None:
        """Write the file."""
        parts = {"bufferViews": self.views, "accessors": self.accessors, "buffers": [{"byteLength": len(self.data)}]}
        text = json.dumps({"asset": {"version": "2.0"}, **parts, **content}, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = [(b"JSON", text), (b"BIN\0", self.data)]
        body = b"".join(len(data).to_bytes(4, "little") + kind + data for kind, data in chunks)
        path.write_bytes(b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body)


def build_mesh() -> tuple[np.ndarray, np.ndarray]:
    """Return points [m], (n, 3), and triangles, (m, 3), of the bust, coarser than those of `make_bust`."""
    spacings = (bust.SPACING_X, bust.SPACING_Y, bust.SPACING_Z)
    right, *rest = (bust.graded_axis(tuple((x, COARSE * step) for x, step in spacing)) for spacing in spacings)
    right = right + 0.5 * COARSE * bust.SPACING_X[0][1]
    axes = (np.concatenate([-right[::-1], right]), *rest)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    points, triangles = extract_surface(evaluate(BUST, grid.reshape(-1, 3)).reshape(grid.shape[:3]), axes)
    return relax(project(BUST, points, steps=2), triangles, partial(project, BUST), rounds=6), triangles


def quaternions(axis: tuple[float, float, float], degrees: np.ndarray) -> np.ndarray:
    """Return rotations about an axis, (k, 4) float32."""
    half = np.radians(degrees) / 2
    return np.column_stack([np.sin(half)[:, None] * axis, np.cos(half)]).astype(np.float32)


def clip(file: Glb, name: str, axis: tuple[float, float, float], degrees: float, jaw: int) -> dict[str, object]:
    """Return an animation that turns neck and head about an axis, and opens the jaw."""
    swing = np.sin(np.pi * KEYS) * np.sin(0.5 * np.pi * np.minimum(KEYS, 2.0 - KEYS)) ** 2
    times = file.add(KEYS.astype(np.float32), "SCALAR", min=[float(KEYS[0])], max=[float(KEYS[-1])])
    turns = [file.add(quaternions(axis, share * degrees * swing), "VEC4") for share in (0.2, 0.3, 0.5)]
    opening = file.add((0.5 - 0.5 * np.cos(2.0 * np.pi * KEYS)).astype(np.float32), "SCALAR")
    samplers = [{"input": times, "output": output} for output in (*turns, opening)]
    channels = [{"sampler": k, "target": {"node": 1 + k, "path": "rotation"}} for k in range(3)]
    channels.append({"sampler": 3, "target": {"node": jaw, "path": "weights"}})
    return {"name": name, "samplers": samplers, "channels": channels}


def write_character(path: Path) -> None:
    """Write the bust with its joints, a map of the scalp, the jaw and the clips `nod` and `shake`."""
    points, triangles = build_mesh()
    joints = bust.build_skeleton()
    file = Glb()
    weights = np.rint(255 * bust.blend_weights(points)).astype(np.uint8)
    scalp = height_above(bust.HAIRLINE, points - bust.EARS)
    attributes = {
        "POSITION": file.add(points.astype(np.float32), "VEC3"),
        "JOINTS_0": file.add(np.tile(np.arange(4, dtype=np.uint8), (len(points), 1)), "VEC4"),
        "WEIGHTS_0": file.add(weights, "VEC4", normalized=True),
        "_SCALP": file.add(np.rint(255 * scalp).astype(np.uint8), "SCALAR", normalized=True),
    }
    fall = np.exp(-np.square((points - JAW) / (0.035, 0.03, 0.04)).sum(axis=1))
    rows = np.flatnonzero(fall > 0.01)
    index = file.add(rows.astype(np.uint16), "SCALAR")
    moved = file.add((fall[rows, None] * (0.0, -0.012, -0.004)).astype(np.float32), "VEC3")
    sparse = {
        "count": len(rows),
        "indices": {"bufferView": file.accessors[index]["bufferView"], "componentType": 5123},
        "values": {"bufferView": file.accessors[moved]["bufferView"]},
    }
    file.accessors.append({"componentType": 5126, "type": "VEC3", "count": len(points), "sparse": sparse})
    target = {"POSITION": len(file.accessors) - 1}
    indices = file.add(triangles.astype(np.uint16).ravel(), "SCALAR")
    bind = np.tile(np.eye(4, dtype=np.float32), (4, 1, 1))
    bind[:, 3, :3] = -joints.rest[:, :3, 3]  # column by column
    primitive = {"attributes": attributes, "indices": indices, "targets": [target]}
    steps = np.diff(joints.rest[:, :3, 3], axis=0, prepend=0.0)
    nodes = [{"name": name, "translation": step.tolist()} for name, step in zip(joints.names, steps, strict=True)]
    nodes = [node | ({"children": [k + 1]} if k < 3 else {}) for k, node in enumerate(nodes)]
    clips = [clip(file, "nod", (1.0, 0.0, 0.0), 28.0, 4), clip(file, "shake", (0.0, 1.0, 0.0), 60.0, 4)]
    file.write(
        path,
        skins=[{"joints": [0, 1, 2, 3], "inverseBindMatrices": file.add(bind.reshape(4, 16), "MAT4")}],
        meshes=[{"name": "bust", "primitives": [primitive], "weights": [0.0]}],
        nodes=[*nodes, {"name": "bust", "mesh": 0, "skin": 0}],
        animations=clips,
        scenes=[{"nodes": [0, 4]}],
    )


if __name__ == "__main__":
    write_character(Path(__file__).with_suffix(".glb"))
