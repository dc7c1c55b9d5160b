"""A body as it came from a file made ready: metres, Y up, no stray vertices, always a joint to move it by."""

import warnings
from dataclasses import replace

import numpy as np

from hairpipe.body.scalp import Scalp, between_ears, paint_scalp
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import Z_UP
from hairpipe.values import Body, DualQuaternions, Mesh, Skeleton

LARGEST_HEAD = 0.35  # from the chin up, with hair that is modelled [m]
SMALLEST, LARGEST = 0.05, 4.0  # [m] of a head and of a person, with room to spare


def prepare(body: Body, *, unit: float, up: str, joint: str, scalp: Scalp | None) -> Body:
    """Return the body in metres with Y up, vertices that no triangle uses dropped, and rigged. Pure.

    A body without a skeleton gets one joint of this name; with a rule a map "scalp". Raises BadInput where the mesh is
    empty or broken; warns where its size is not that of a person or a head.
    """
    mesh = body.mesh
    if not len(mesh.triangles):
        raise BadInput("the body has no triangles", where="file", right="a mesh")
    if mesh.triangles.min() < 0 or mesh.triangles.max() >= len(mesh.points):
        right = f"0 to {len(mesh.points) - 1}"
        raise BadInput("a triangle names a vertex that does not exist", where="file", right=right)
    for name, values in (("positions", mesh.points), ("joints", body.skeleton.rest), ("weights", body.weights)):
        if not np.isfinite(values).all():
            raise BadInput(f"{name} are not all finite", where="file", right="finite numbers")
    body = drop_unused(body)
    body = transform(body, unit * (Z_UP if up == "z" else np.eye(3)))
    size = np.ptp(body.mesh.points, axis=0).max()
    if not SMALLEST <= size <= LARGEST:
        warnings.warn(
            f"the body is {size:.3g} m large: is unit = {unit:g} (metres in one unit of the file)?", stacklevel=2
        )
    if not body.skeleton.names:
        # One joint at the middle of the vertices, its tip at their top, moves the body rigidly.
        points = body.mesh.points
        rest = np.eye(4)[None].copy()
        rest[0, :3, 3] = points.mean(axis=0)
        tip = points.mean(axis=0) * (1.0, 0.0, 1.0) + (0.0, points[:, 1].max(), 0.0)
        skeleton = Skeleton((joint,), np.array([-1], np.int32), rest, tip[None])
        bound = body.bound and replace(body.bound, turns=np.eye(4)[None])
        joints = np.zeros((len(points), 1), np.int32)
        weights = np.ones((len(points), 1))
        body = replace(body, skeleton=skeleton, joints=joints, weights=weights, bound=bound)
        if scalp is not None and scalp.at is None and np.ptp(points[:, 1]) > LARGEST_HEAD:
            scalp = replace(scalp, at=between_ears(points))
            place = ", ".join(f"{x:.3f}" for x in between_ears(points))
            guessed = f"the body has no skeleton to locate its head: the hairline is centred at ({place}) m"
            warnings.warn(f"{guessed}; scalp.at, the point between the ears, corrects this", stacklevel=2)
    return body if scalp is None else replace(body, maps={**body.maps, "scalp": paint_scalp(body, scalp)})


def drop_unused(body: Body) -> Body:
    """Return the body without vertices that no triangle uses, and without weights that are 0 all down. Pure."""
    mesh = body.mesh
    used = np.unique(mesh.triangles)
    place = np.zeros(len(mesh.points), np.int32)
    place[used] = np.arange(len(used))
    weights = body.weights[used]
    filled = np.flatnonzero((weights != 0.0).any(axis=0))
    dual, shapes = body.dual, body.shapes
    if dual is not None:
        kept = np.isin(dual.vertices, used)
        dual = DualQuaternions(place[dual.vertices[kept]], dual.centres[kept])
    if shapes is not None:
        kept = np.isin(shapes.vertices, used)
        rows = np.concatenate([[0], np.cumsum(kept)])[shapes.rows]
        shapes = replace(shapes, rows=rows, vertices=place[shapes.vertices[kept]], offsets=shapes.offsets[kept])
    return replace(
        body,
        mesh=Mesh(mesh.points[used], place[mesh.triangles], uv=mesh.uv),
        joints=np.take(body.joints[used], filled, axis=1),
        weights=np.take(weights, filled, axis=1),
        maps={name: values[used] for name, values in body.maps.items()},
        dual=dual,
        shapes=shapes,
        bound=body.bound and replace(body.bound, points=body.bound.points[used]),
    )


def follow(rest: Body | None, mesh: Mesh, owners: np.ndarray, *, unit: float, up: str) -> Mesh:
    """Return an animated mesh in metres with Y up, with the vertices and triangles of the body at rest. Pure.

    owners  polygons of the triangles, (m,)

    Raises BadInput where the mesh is not that of the body; it may have been cut into other triangles.
    """
    used = np.unique(mesh.triangles)
    triangles = np.searchsorted(used, mesh.triangles).astype(np.int32)
    matrix = unit * (Z_UP if up == "z" else np.eye(3))
    points, velocities = mesh.points[used] @ matrix.T, mesh.rates[used] @ matrix.T
    if rest is None:
        return Mesh(points, triangles, velocities, mesh.uv)
    own = rest.mesh
    if len(used) != len(own.points) or len(triangles) != len(own.triangles):
        what = f"the mesh has {len(used):,} vertices and {len(triangles):,} triangles"
        right = f"those of the body at rest: {len(own.points):,} and {len(own.triangles):,}"
        raise BadInput(what, where="file", right=right)
    polygons = np.repeat(owners, 3)  # which may be cut along other diagonals
    theirs, ours = (
        np.unique(np.stack([polygons, corners.ravel()], axis=1), axis=0) for corners in (triangles, own.triangles)
    )
    if not (np.array_equal(triangles, own.triangles) or np.array_equal(theirs, ours)):
        right = "polygons in the same order, of the same vertices"
        raise BadInput("the polygons are not those of the body at rest", where="file", right=right)
    return Mesh(points, own.triangles, velocities, own.uv)


def transform(body: Body, matrix: np.ndarray) -> Body:
    """Return the body with positions multiplied by a matrix (3, 3): a rotation times a scale. Pure."""
    rest = body.skeleton.rest.copy()
    rest[:, :3, 3] = rest[:, :3, 3] @ matrix.T
    rest[:, :3, :3] = matrix @ rest[:, :3, :3] / np.cbrt(np.linalg.det(matrix))
    skeleton = replace(body.skeleton, rest=rest, tips=body.skeleton.tips @ matrix.T)
    shapes, bound, dual = body.shapes, body.bound, body.dual
    if bound is not None:
        turns = bound.turns.copy()
        turns[:, :3, :3] = matrix @ turns[:, :3, :3] @ np.linalg.inv(matrix)
        turns[:, :3, 3] = turns[:, :3, 3] @ matrix.T
        bound = replace(bound, points=bound.points @ matrix.T, turns=turns)
    return replace(
        body,
        mesh=replace(body.mesh, points=body.mesh.points @ matrix.T),
        skeleton=skeleton,
        dual=dual and replace(dual, centres=dual.centres @ matrix.T),
        shapes=shapes and replace(shapes, offsets=shapes.offsets @ matrix.T),
        bound=bound,
    )
