"""What hairpipe reads of a scene: hair as groomed, surfaces with all their modifiers, gravity and wind.

Positions are given in metres, in the axes of a graph: gravity points along -Y. Blender's own are its units, mostly with
gravity along -Z.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

Z_UP_TO_Y_UP = Matrix(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
DOWN = Vector((0.0, 0.0, -1.0))
SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")
"""Types of objects that have faces after evaluation."""
STANDARD = (
    *("position", "radius", "surface_uv_coordinate", "curve_type", "cyclic", "resolution", "id", "widths"),
    *("hairId", "hairDiameter", "lockId", "skinprim", "displayOpacity", "groom_id", "groom_guide", "groom_group_id"),
)
"""Attributes with a meaning of their own in Blender or in a groom file, which are not maps."""
NUMBERS = {"FLOAT": np.float32, "INT": np.int32, "BOOLEAN": bool, "INT8": np.int8}


class Refused(Exception):
    """Something in the scene cannot be used; the message names the object and says what would be right."""


class Axes(NamedTuple):
    """How the world of a scene becomes that of a graph: a rotation, (3, 3), and the metres of a unit."""

    rotation: np.ndarray
    metres: float

    def points(self, world: np.ndarray) -> np.ndarray:
        """Turn places of the world, (n, 3), into metres."""
        return self.metres * (world @ self.rotation.T)

    def vector(self, world: Sequence[float]) -> list[float]:
        """Turn a vector in SI units, (3,), such as a velocity."""
        return [float(f"{number:.6g}") + 0.0 for number in self.rotation @ np.asarray(world, float)]

    def matrix(self) -> Matrix:
        """Return the matrix of an object whose own coordinates are those of the graph, (4, 4)."""
        return (Matrix(self.rotation.T.tolist()) * (1.0 / self.metres)).to_4x4()


def axes_of(scene: Any) -> Axes:
    """Return the axes of a graph for a scene: metres from its unit, down from its gravity."""
    rotation = Z_UP_TO_Y_UP
    gravity = Vector(scene.gravity)
    if scene.use_gravity and gravity.length > 0.0:
        rotation = rotation @ gravity.normalized().rotation_difference(DOWN).to_matrix()
    metres = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    return Axes(np.array(rotation), metres)


def gravity_of(scene: Any) -> float:
    """Return the strength of the gravity of a scene [m/s^2]."""
    return float(f"{Vector(scene.gravity).length:.6g}") if scene.use_gravity else 0.0


def wind_of(scene: Any) -> list[float] | None:
    """Return the sum of the wind fields of a scene at this frame [m/s], in its axes; None without any.

    Blender has no unit of their strength: it is taken as a velocity.
    """
    fields = [o for o in scene.objects if o.field is not None and o.field.type == "WIND" and not o.hide_viewport]
    if not fields:
        return None
    winds = [o.matrix_world.to_3x3().normalized() @ Vector((0.0, 0.0, o.field.strength)) for o in fields]
    return list(sum(winds, Vector()))


class Faces(NamedTuple):
    """A surface at a time: places, (n, 3) float64 [m], and polygons as numbers of corners and the corners of all."""

    points: np.ndarray
    sizes: np.ndarray
    corners: np.ndarray


class Hair(NamedTuple):
    """Curves as groomed.

    points   (p, 3) float64 [m]
    sizes    number of points of each curve, (S,)
    ids      index of each in the object, (S,)
    radii    (p,) float64 [m]
    uv       texture coordinates of the roots, (S, 2), or None
    maps     numbers of each curve, (S,) float64, by name
    pinned   which points are pinned, (p,) bool, or None
    omitted  number of curves that have one point or no length
    """

    points: np.ndarray
    sizes: np.ndarray
    ids: np.ndarray
    radii: np.ndarray
    uv: np.ndarray | None
    maps: dict[str, np.ndarray]
    pinned: np.ndarray | None
    omitted: int


@contextmanager
def shown(context: Any, objects: Sequence[Any]) -> Iterator[None]:
    """Have objects evaluated that are hidden, or in a collection that is; they are as before afterwards."""
    layer, scene = context.view_layer, context.scene
    linked, hidden, closed = [], [], []
    for item in objects:
        if not item.visible_get(view_layer=layer) and item.name not in scene.collection.objects:
            scene.collection.objects.link(item)
            linked.append(item)
        if item.hide_viewport:
            item.hide_viewport = False
            hidden.append(item)
        if item.hide_get(view_layer=layer):
            item.hide_set(False, view_layer=layer)
            closed.append(item)
    try:
        yield
    finally:
        for item in closed:
            item.hide_set(True, view_layer=layer)
        for item in hidden:
            item.hide_viewport = True
        for item in linked:
            scene.collection.objects.unlink(item)


def check_instances(items: Sequence[Any], graph: Any) -> None:
    """Raise Refused for an object that makes instances."""
    made = {one.parent.original for one in graph.object_instances if one.is_instance and one.parent}
    for item in items:
        if item.instance_type != "NONE" or item in made:
            raise Refused(f"{item.name} has instances: realize them (Realize Instances, Make Instances Real)")


def read_faces(item: Any, graph: Any, axes: Axes) -> Faces:
    """Return the surface of an object with all its modifiers at the frame of a depsgraph; Refused without faces."""
    if item.type not in SURFACES:
        raise Refused(f"{item.name} is not a surface: pick a mesh")
    found = item.evaluated_get(graph)
    mesh = found.to_mesh()
    try:
        if not len(mesh.polygons):
            raise Refused(f"{item.name} has no faces")
        points = numbers_of(mesh.vertices, "co", 3)
        sizes = numbers_of(mesh.polygons, "loop_total", 1, np.int32)
        corners = numbers_of(mesh.loops, "vertex_index", 1, np.int32)
    finally:
        found.to_mesh_clear()
    matrix = np.array(found.matrix_world)
    if np.linalg.det(matrix[:3, :3]) < 0.0:  # a mirrored surface is seen from its other side
        corners = turned(corners, sizes)
    return Faces(axes.points(points @ matrix[:3, :3].T + matrix[:3, 3]), sizes, corners)


def turned(corners: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return the corners of polygons in the other order."""
    first = np.repeat(np.cumsum(sizes) - sizes, sizes)
    return corners[2 * first + np.repeat(sizes, sizes) - 1 - np.arange(len(corners))]


def numbers_of(rows: Any, name: str, columns: int, kind: Any = np.float32) -> np.ndarray:
    """Return a number or vector of all rows of a collection, (n,) or (n, columns): fractions in float64."""
    found = np.empty(len(rows) * columns, kind)
    rows.foreach_get(name, found)
    found = found.astype(np.float64) if kind is np.float32 else found
    return found.reshape(-1, columns) if columns > 1 else found


def read_hair(item: Any, graph: Any, axes: Axes, body: Any, wanted: Sequence[str], pins: str) -> Hair:
    """Return the curves of a hair object with all its modifiers at the frame of a depsgraph.

    body    object with vertex groups that may be maps
    wanted  names of maps that settings use: attributes of the curves, or vertex groups of the body
    pins    name of an attribute that is above 0.5 at pinned points or curves, or empty
    Raises Refused where there are no curves, or no such map.
    """
    if item.type != "CURVES":
        raise Refused(f"{item.name} is not a hair curves object")
    found = item.evaluated_get(graph)
    curves = found.data
    offsets = numbers_of(curves.curve_offset_data, "value", 1, np.int32) if len(curves.curves) else np.zeros(1, int)
    sizes = np.diff(offsets)
    local = numbers_of(curves.position_data, "vector", 3)
    matrix = np.array(found.matrix_world)
    points = axes.points(local @ matrix[:3, :3].T + matrix[:3, 3])
    owners = np.repeat(np.arange(len(sizes)), sizes)
    steps = np.where(owners[1:] == owners[:-1], np.linalg.norm(np.diff(points, axis=0), axis=1), 0.0)
    lengths = np.bincount(owners[1:], steps, len(sizes)) if len(points) > 1 else np.zeros(len(sizes))
    kept = (sizes > 1) & (lengths > 0.0) & np.isfinite(lengths)
    if not kept.any():
        raise Refused(f"{item.name} has no curve of two or more points")
    rows = np.repeat(kept, sizes)
    size = axes.metres * abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3)
    radii = values_at(curves, "radius", "POINT")
    radii = np.full(len(points), 0.005) if radii is None else radii
    uv = curves.attributes.get("surface_uv_coordinate")
    maps = maps_of(item, curves, owners, body, points[offsets[:-1].clip(max=max(len(points) - 1, 0))], wanted, axes)
    return Hair(
        points[rows],
        sizes[kept],
        np.flatnonzero(kept),
        size * radii[rows],
        None if uv is None else numbers_of(uv.data, "vector", 2)[kept],
        {name: values[kept] for name, values in maps.items()},
        pinned_points(item, curves, owners, pins)[rows] if pins else None,
        int((~kept).sum()),
    )


def values_at(curves: Any, name: str, domain: str) -> np.ndarray | None:
    """Return the numbers of an attribute, (n,) float64; None if there is no such attribute."""
    found = curves.attributes.get(name)
    if found is None or found.domain != domain or found.data_type not in NUMBERS:
        return None
    return numbers_of(found.data, "value", 1, NUMBERS[found.data_type]).astype(np.float64)


def maps_of(
    item: Any, curves: Any, owners: np.ndarray, body: Any, roots: np.ndarray, wanted: Sequence[str], axes: Axes
) -> dict[str, np.ndarray]:
    """Return a number of each curve, by name: of attributes, of points in their mean, and of wanted vertex groups."""
    found = {}
    counts = np.maximum(np.bincount(owners, minlength=len(curves.curves)), 1)
    for attribute in curves.attributes:
        own = values_at(curves, attribute.name, "CURVE")
        if own is None and (along := values_at(curves, attribute.name, "POINT")) is not None:
            own = np.bincount(owners, along, len(counts)) / counts
        if own is not None and attribute.name not in STANDARD and not attribute.name.startswith("."):
            found[attribute.name] = own
    for name in wanted:
        if name not in found:
            group = None if body is None else body.vertex_groups.get(name)
            if group is None:
                where = f"{item.name} and {body.name}" if body else item.name
                raise Refused(f"no attribute and no vertex group '{name}': {where} do not have it")
            found[name] = weights_at(body, group.index, roots, axes)
    return found


def weights_at(body: Any, group: int, places: np.ndarray, axes: Axes) -> np.ndarray:
    """Return the weights of a vertex group at the places of a body nearest to roots, (S,)."""
    mesh = body.data
    mesh.calc_loop_triangles()
    corners = numbers_of(mesh.loop_triangles, "vertices", 3, np.int32)
    weights = np.zeros(len(mesh.vertices))
    for vertex in mesh.vertices:
        for entry in vertex.groups:
            if entry.group == group:
                weights[vertex.index] = entry.weight
    back = body.matrix_world.inverted() @ axes.matrix()
    points = [vertex.co for vertex in mesh.vertices]
    tree = BVHTree.FromPolygons(points, corners.tolist())
    found = np.zeros(len(places))
    for row, place in enumerate(places.tolist()):
        near, _, triangle, _ = tree.find_nearest(back @ Vector(place))
        if near is not None:
            shares = barycentrics(near, *(points[corner] for corner in corners[triangle]))
            found[row] = shares @ weights[corners[triangle]]
    return found


def barycentrics(at: Vector, a: Vector, b: Vector, c: Vector) -> np.ndarray:
    """Return the barycentric coordinates of a place of a triangle, (3,)."""
    normal = (b - a).cross(c - a)
    whole = normal.length_squared or 1.0
    second = (a - c).cross(at - c).dot(normal) / whole
    third = (b - a).cross(at - a).dot(normal) / whole
    return np.array((1.0 - second - third, second, third))


def pinned_points(item: Any, curves: Any, owners: np.ndarray, name: str) -> np.ndarray:
    """Return which points are pinned, (p,) bool: an attribute of points or curves is above 0.5."""
    along = values_at(curves, name, "POINT")
    if along is not None:
        return along > 0.5
    own = values_at(curves, name, "CURVE")
    if own is None:
        raise Refused(f"{item.name} has no attribute '{name}' for its pins")
    return own[owners] > 0.5
