"""Rig of a MakeHuman body (.mhskel, .mhw): bones between means of vertices, and the weights of the vertices."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.text import read_text
from hairpipe.values import Skeleton


def read_skeleton(path: Path, points: np.ndarray) -> Skeleton:
    """Read the bones of a rig as joints at their heads, in the units of the points; every frame is that of the world.

    points  all vertices of the base mesh, helpers included, (n, 3)

    Raises BadInput where the file is not a rig or does not fit the mesh.
    """
    content = _read_object(path)
    bones, spots = _member(path, content, "bones", dict), _member(path, content, "joints", dict)
    order = _order_by_parent(path, bones)
    heads = np.array([_spot(path, bones, spots, name, "head", points) for name in order])
    tips = np.array([_spot(path, bones, spots, name, "tail", points) for name in order])
    rest = np.tile(np.eye(4), (len(order), 1, 1))
    rest[:, :3, 3] = heads
    index = {name: joint for joint, name in enumerate(order)}
    parents = np.array([index.get(bones[name].get("parent"), -1) for name in order], np.int32)
    return Skeleton(tuple(order), parents, rest, tips)


def read_weights(path: Path, names: tuple[str, ...], vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Read joint indices (n, k) int32 and weights (n, k) of n vertices, heaviest first, at most k joints per vertex.

    Rows are scaled to sum to 1; a vertex that the file omits follows joint 0.
    Raises BadInput where the file holds no weights or does not fit mesh and skeleton.
    """
    table = _member(path, _read_object(path), "weights", dict)
    dense = np.zeros((vertices, len(names)))
    index = {name: joint for joint, name in enumerate(names)}
    for name, rows in table.items():
        if name not in index:
            raise BadInput(f"the skeleton has no bone {name!r}", where=path, right="weights made for this skeleton")
        which, weight = _weight_rows(path, name, rows, vertices)
        np.add.at(dense[:, index[name]], which, weight)
    dense[dense.sum(axis=1) == 0.0, 0] = 1.0
    most = int((dense > 0.0).sum(axis=1).max())
    joints = np.argsort(-dense, axis=1, kind="stable")[:, :most]
    weights = np.take_along_axis(dense, joints, axis=1)
    return joints.astype(np.int32), weights / weights.sum(axis=1, keepdims=True)


def _weight_rows(path: Path, bone: str, rows: Any, vertices: int) -> tuple[np.ndarray, np.ndarray]:
    right = f"pairs [vertex 0 to {vertices - 1}, weight of 0 or more]"
    where = f"{path}, weights.{bone}"
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        raise BadInput("the list does not consist of pairs", where=where, right=right)
    for vertex, weight in rows:
        is_weight = isinstance(weight, int | float) and not isinstance(weight, bool) and 0.0 <= weight <= 1e6
        if not is_weight or not _is_index(vertex, vertices):
            raise BadInput(f"[{vertex!r:.40}, {weight!r:.40}] is out of range", where=where, right=right)
    pairs = np.array(rows, np.float64).reshape(-1, 2)
    return pairs[:, 0].astype(np.int64), pairs[:, 1]


def _is_index(value: Any, count: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count


def _read_object(path: Path) -> dict[str, Any]:
    text = read_text(path)
    try:
        content = json.loads(text)
    except json.JSONDecodeError as fault:
        raise BadInput(fault.msg, where=f"{path}, line {fault.lineno}", right="a JSON file") from None
    except (ValueError, RecursionError):
        raise BadInput("the JSON is nested too deeply or holds too long a number", where=path) from None
    if not isinstance(content, dict):
        raise BadInput("the JSON is not an object", where=path, right="{ ... }")
    return content


def _member(path: Path, content: dict[str, Any], name: str, kind: type) -> Any:
    value = content.get(name)
    if not isinstance(value, kind) or not value:
        raise BadInput(f"{name!r} is missing, empty or not a {kind.__name__}", where=path, right="a MakeHuman rig")
    return value


def _order_by_parent(path: Path, bones: dict[str, Any]) -> list[str]:
    """Names of the bones, parents first, otherwise in the order of the file."""
    children: dict[str | None, list[str]] = {}
    for name, bone in bones.items():
        parent = bone.get("parent") if isinstance(bone, dict) else ""
        if parent is not None and (not isinstance(parent, str) or parent not in bones):
            raise BadInput(f"parent {parent!r} does not exist", where=f"{path}, bones.{name}", right="a bone or null")
        children.setdefault(parent, []).append(name)
    order = []
    waiting = children.get(None, [])[::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += children.get(order[-1], [])[::-1]
    if len(order) < len(bones):
        lost = next(name for name in bones if name not in set(order))
        raise BadInput("the bone is its own ancestor", where=f"{path}, bones.{lost}", right="parents up to a root")
    return order


def _spot(path: Path, bones: dict, spots: dict, name: str, end: str, points: np.ndarray) -> np.ndarray:
    """Position of one end of a bone: the mean of some vertices."""
    spot = bones[name].get(end)
    which = spots.get(spot) if isinstance(spot, str) else None
    if not isinstance(which, list) or not which or not all(_is_index(vertex, len(points)) for vertex in which):
        what = "the joint is missing or names vertices that do not exist"
        raise BadInput(what, where=f"{path}, bones.{name}.{end}", right="a list of vertices")
    return points[which].mean(axis=0)
