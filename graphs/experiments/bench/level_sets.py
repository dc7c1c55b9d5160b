"""Errors of baked level sets: our distances and OpenVDB's against all triangles and the winding number."""

from collections.abc import Iterator

import numpy as np

from hairpipe.body.bust import build_bust
from hairpipe.body.shapes import build_box, build_cylinder
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report
from hairpipe.levelset.bake import bake, bake_by_openvdb
from hairpipe.openvdb_library import find_openvdb
from hairpipe.values import LevelSet, Mesh
from hairpipe.values.body import BRICK

ENGINES = {"hairpipe": bake, "openvdb": bake_by_openvdb}
HALF_WIDTH = 4.0
PAIRS = 1 << 18
"""Samples times triangles that are held at a time."""


def measure_level_sets(
    echo: Echo, voxels: tuple[float, ...] = (0.01, 0.005, 0.003), samples: int = 1000, small: bool = False
) -> Report:
    """Measure the engines on bodies without overlaps; without OpenVDB's module only ours.

    voxels   spacings [m]
    samples  of the band that are compared, and as many within a voxel of the surface
    small    whether the bust is left out
    """
    cases = list[Case]()
    for body, mesh in bodies(small):
        for voxel in voxels:
            echo(f"{body} at {1000 * voxel:g} mm")
            ours = bake(mesh, voxel, HALF_WIDTH, "refuse")
            chosen = chosen_samples(ours, samples)
            exact = exact_distances(mesh, points_of(ours)[chosen])
            for engine, make in ENGINES.items():
                if engine == "hairpipe" or find_openvdb():
                    found = make(mesh, voxel, HALF_WIDTH, "refuse").distance.reshape(-1)[chosen].astype(float)
                    cases.append({"body": body, "triangles": len(mesh.triangles), "voxel [mm]": 1000 * voxel})
                    cases[-1] |= {"engine": engine, **errors_of(found, exact)}
    return make_report(__name__, {"level sets": cases})


def bodies(small: bool) -> Iterator[tuple[str, Mesh]]:
    """Yield closed bodies by name, turned against the lattice; the bust only if it is not to be small."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    shapes = {
        "box": build_box((0.1, 0.06, 0.08), (0.0, 0.0, 0.0)),
        "capsule": build_cylinder(0.04, 0.12, True, 48, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        "plate": build_box((0.1, 0.1, 0.012), (0.0, 0.0, 0.0)),
    }
    for name, mesh in shapes.items():
        yield name, Mesh(mesh.points @ turn, mesh.triangles)
    if not small:
        yield "bust", build_bust().mesh


def points_of(surface: LevelSet) -> np.ndarray:
    """Return the positions of all samples of the bricks, (B 9^3, 3) [m]."""
    places = np.argwhere(surface.bricks >= 0)
    order = np.argsort(surface.bricks[tuple(places.T)])
    shifts = np.indices(3 * (BRICK + 1,)).reshape(3, -1).T
    return (surface.origin + surface.voxel * (BRICK * places[order][:, None] + shifts)).reshape(-1, 3)


def chosen_samples(surface: LevelSet, count: int) -> np.ndarray:
    """Return samples of the band, then as many within a voxel of the surface, at random."""
    generator = np.random.default_rng(0)
    far = np.abs(surface.distance.reshape(-1))
    widths = (surface.voxel * (HALF_WIDTH - 1), surface.voxel)
    return np.concatenate([generator.choice(np.flatnonzero(far < width), count) for width in widths])


def errors_of(found: np.ndarray, exact: np.ndarray) -> Case:
    """Return errors of signed distances [m]; pure."""
    off = 1000 * np.abs(np.abs(found) - np.abs(exact))
    wrong = (found < 0.0) != (exact < 0.0)
    return {
        "samples": len(exact),
        "largest error [mm]": float(off.max()),
        "mean error [mm]": float(off.mean()),
        "wrong signs": int(wrong.sum()),
        "deepest of these [mm]": float(1000 * np.abs(exact[wrong]).max(initial=0.0)),
    }


def exact_distances(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Return the distance of points (n, 3) to the nearest of all triangles, negative where they wind around it [m].

    The winding number is the sum of the solid angles of the triangles over 4 pi (van Oosterom and Strackee 1983).
    """
    corners = mesh.points[mesh.triangles]
    found = np.empty(len(points))
    step = max(PAIRS // len(corners), 1)
    for first in range(0, len(points), step):
        own = points[first : first + step]
        around = corners[None] - own[:, None, None]
        squared = np.minimum(squared_to_faces(around), squared_to_edges(around)).min(axis=1)
        inside = np.abs(solid_angles(around).sum(axis=1)) > 2 * np.pi
        found[first : first + step] = np.where(inside, -1.0, 1.0) * np.sqrt(squared)
    return found


def squared_to_faces(around: np.ndarray) -> np.ndarray:
    """Return the squared distance from the origin to triangles (..., 3, 3) whose plane is nearest inside them."""
    a, b, c = (around[..., k, :] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.einsum("...j,...j->...", normal, normal)
    foot = (np.einsum("...j,...j->...", a, normal) / length)[..., None] * normal
    sides = [np.einsum("...j,...j->...", np.cross(q - p, foot - p), normal) >= 0.0 for p, q in ((a, b), (b, c), (c, a))]
    return np.where(np.logical_and.reduce(sides), np.einsum("...j,...j->...", foot, foot), np.inf)


def squared_to_edges(around: np.ndarray) -> np.ndarray:
    """Return the squared distance from the origin to the nearest edge of triangles (..., 3, 3)."""
    ways = np.roll(around, -1, axis=-2) - around
    along = -np.einsum("...j,...j->...", around, ways) / np.einsum("...j,...j->...", ways, ways)
    feet = around + np.clip(along, 0.0, 1.0)[..., None] * ways
    return np.einsum("...j,...j->...", feet, feet).min(axis=-1)


def solid_angles(around: np.ndarray) -> np.ndarray:
    """Return the solid angles of triangles (..., 3, 3) seen from the origin."""
    a, b, c = (around[..., k, :] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
    ab, bc, ca = (np.einsum("...j,...j->...", x, y) for x, y in ((a, b), (b, c), (c, a)))
    volume = np.einsum("...j,...j->...", a, np.cross(b, c))
    return 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
