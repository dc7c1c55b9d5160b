"""Faults, and what rules look at: hair and meshes over time, with one frame of one shape in memory, and their roots."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from hairpipe.errors import BadInput
from hairpipe.formats.usd.meshes import Binding, find_bindings
from hairpipe.formats.usd.stage import RENDERED, spaces_of, to_metres

Severity = Literal["error", "warning", "change", "note"]
"""Of a finding: a fault, or a difference from another file, or what a program does not show."""
FAULTS = ("error", "warning")
Subject = Literal["stage", "asset", "prim", "field", "curves", "shape", "frame", "scene", "hair"]
"""Arguments of a rule: the stage, a file that it names, a prim, a field of a volume and a reader of its file, curves or
any shape at one time, sound hair with its motion at one time, all visible shapes, or these and one hair over time."""


class Fault(NamedTuple):
    """A fault found by a rule.

    path     of the layer, prim or attribute
    message  fault and remedy
    time     time code, or None where the fault does not depend on time
    """

    path: str
    message: str
    time: float | None = None


def fault_of(item: Any, message: str, time: float | None = None) -> Fault:
    """Return a fault of a prim or property."""
    return Fault(str(item.GetPath()), message, time)


class Rule(NamedTuple):
    """A rule for stages: an error breaks the picture, a warning breaks the use in other programs."""

    name: str
    severity: Severity
    subject: Subject
    faults: Callable[..., Iterator[Fault]]


@dataclass(frozen=True)
class Cause:
    """The node of a graph that caused a finding, its settings by full name, and what to write there."""

    node: str
    settings: dict[str, Any]
    write: str

    def __str__(self) -> str:
        shown = ", ".join(f"{name} = {_written(value)}" for name, value in self.settings.items())
        return f"from {shown}: write {self.write}" if shown else f"write {self.write}"


def _written(value: Any) -> str:
    """Write a value of a setting as a graph file has it; a file by the first digits of its digest."""
    if isinstance(value, dict):
        if "file" in value:
            return f"bytes {str(value['file'])[:8]}"
        inner = {name: inner for name, inner in value.items() if inner not in (None, [], 0.0)}
        return _written(value["value"]) if inner.keys() == {"value"} else json.dumps(inner)
    return "absent" if value is None else json.dumps(value)


@dataclass(frozen=True)
class Finding:
    """A rule that is broken at one place, by its name.

    time    first time code
    count   number of faults
    cause   in the graph behind the file, where the file states it
    values  numbers of the message, by region
    """

    rule: str
    path: str
    time: float | None
    message: str
    severity: Severity
    count: int = 1
    cause: Cause | None = None
    values: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        time = "" if self.time is None else f" @ {self.time:g}"
        more = "" if self.count == 1 else f" [{self.count} times]"
        return f"{self.severity}: {self.rule}: {self.path}{time}: {self.message}{more}" + (
            f"; {self.cause}" if self.cause else ""
        )


TOKENS = UsdGeom.Tokens
TINY = np.finfo(np.float64).tiny
REST = (2 / 3, 3 / 2)
"""Accepted lengths at rest over those at the first time: a rest pose in the unit of the points."""
OURS = ("primvars:hairId", "primvars:pref", "primvars:skinprim", "velocities")
MANY = 20  # fewest curves that are hair
OFF = 0.01  # of a strand's length: largest distance of a bound root from the skin
LOOSE = 0.1  # the same of a root without an authored face, which may slide
FAR = 20.0  # times that: distance from which a single root is a fault
MOST = 0.5  # least share of strands with a valid face of a mesh
PROBED = 64  # strands of which the nearest place is searched
BLOCK = 1 << 17  # pairs of point and triangle in memory


class Snapshot:
    """Curves or a mesh at one time; an absent attribute, or one that is not an array of numbers, is None or empty.

    curves    whether these are curves
    code      time code, or None for constant shapes
    points    (n, 3) float32, of the attribute `positions`
    counts    vertex counts of curves or faces, (c,) int64
    corners   points at the corners of the faces, (k,) int32
    """

    positions = "points"

    def __init__(self, prim: Usd.Prim, time: Usd.TimeCode) -> None:
        self.prim = prim
        self.time = time
        self.code = None if time.IsDefault() else time.GetValue()
        self.curves = prim.IsA(UsdGeom.BasisCurves)
        self._arrays: dict[str, np.ndarray | None] = {}

    def fault(self, name: str, message: str, timed: bool = True) -> Fault:
        """Return a fault of an attribute, at this time or at all times."""
        return Fault(f"{self.prim.GetPath()}.{name}", message, self.code if timed else None)

    def array(self, name: str, columns: int = 1) -> np.ndarray | None:
        """Return a numeric array attribute, (n,) or (n, columns), as it is stored."""
        if name not in self._arrays:
            value = self.prim.GetAttribute(name).Get(self.time) if self.prim.HasAttribute(name) else None
            array = None if value is None else np.asarray(value)
            self._arrays[name] = array if array is not None and array.dtype.kind in "iuf" else None
        array = self._arrays[name]
        shape = () if columns == 1 else (columns,)
        return array if array is not None and array.ndim and array.shape[1:] == shape else None

    @cached_property
    def points(self) -> np.ndarray:
        points = self.array(self.positions, 3)
        return np.empty((0, 3), np.float32) if points is None else points

    @cached_property
    def counts(self) -> np.ndarray:
        counts = self.array("curveVertexCounts" if self.curves else "faceVertexCounts")
        return np.empty(0, np.int64) if counts is None else counts.astype(np.int64)

    @cached_property
    def corners(self) -> np.ndarray:
        corners = self.array("faceVertexIndices")
        return np.empty(0, np.int32) if corners is None else corners

    @cached_property
    def consistent(self) -> bool:
        """Whether counts and elements agree."""
        elements = self.points if self.curves else self.corners
        return bool(self.counts.sum() == len(elements) and (self.counts >= 0).all())

    @cached_property
    def sound(self) -> bool:
        """Whether these are curves of two or more points each, all finite."""
        whole = self.curves and self.consistent and len(self.counts) and (self.counts > 1).all()
        return bool(whole and np.isfinite(self.points).all())

    @cached_property
    def faces(self) -> bool:
        """Whether this is a mesh with faces, all of existing points."""
        whole = self.consistent and len(self.counts) and len(self.corners) and len(self.points)
        return bool(whole and self.corners.min() >= 0 and self.corners.max() < len(self.points))

    @cached_property
    def triangles(self) -> bool:
        """Whether all faces are triangles, and all points finite."""
        return self.faces and bool((self.counts == 3).all() and np.isfinite(self.points).all())

    @cached_property
    def world(self) -> np.ndarray:
        """Matrix to the world, which acts on row vectors, (4, 4) float64."""
        return np.array(UsdGeom.Xformable(self.prim).ComputeLocalToWorldTransform(self.time))

    @cached_property
    def placed(self) -> np.ndarray:
        """Positions in the world, (n, 3) float64."""
        return self.points @ self.world[:3, :3] + self.world[3, :3]

    @cached_property
    def roots(self) -> np.ndarray:
        """Index of the first point of every curve, or corner of every face, (c,) int64."""
        return np.cumsum(self.counts) - self.counts

    @cached_property
    def tips(self) -> np.ndarray:
        """Index of the last point of every curve, (c,) int64."""
        return np.cumsum(self.counts) - 1

    @cached_property
    def segments(self) -> np.ndarray:
        """Lengths of all segments of valid curves, one curve after the other, (n - c,) float64."""
        steps = np.linalg.norm(np.diff(self.points.astype(np.float64), axis=0), axis=1)
        return np.delete(steps, self.tips[:-1])

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths of valid curves, (c,) float64."""
        return self.per_strand(np.add, self.segments)

    def per_strand(self, reduce: np.ufunc, values: np.ndarray) -> np.ndarray:
        """Reduce values of the segments, (n - c,), to one for every curve, (c,)."""
        return reduce.reduceat(values, self.roots - np.arange(len(self.counts)))

    def size(self, interpolation: str) -> int:
        """Return the number of values of an interpolation."""
        if interpolation == TOKENS.constant:
            return 1
        if interpolation == TOKENS.uniform:
            return len(self.counts)
        if interpolation == TOKENS.faceVarying and not self.curves:
            return len(self.corners)
        if interpolation == TOKENS.vertex or not self.curves:
            return len(self.points)
        return UsdGeom.BasisCurves(self.prim).ComputeVaryingDataSize(self.time)


class RestShape(Snapshot):
    """Hair at rest."""

    positions = "primvars:pref"


def notes_of(stage: Usd.Stage) -> dict[str, Any]:
    """Return our notes in a stage; none in the stage of another program."""
    notes = stage.GetRootLayer().customLayerData.get("hairpipe")
    return notes if isinstance(notes, dict) else {}


class Track:
    """A shape over time.

    prim   curves or a mesh
    times  codes of all samples; empty for a constant shape
    """

    def __init__(self, prim: Usd.Prim) -> None:
        self.prim = prim
        self.times = sorted({time for attribute in prim.GetAttributes() for time in attribute.GetTimeSamples()})

    def at(self, time: float | None) -> Snapshot:
        """Return the shape at a time code, or a constant shape."""
        return Snapshot(self.prim, Usd.TimeCode.Default() if time is None else Usd.TimeCode(time))

    def fault(self, name: str, message: str, time: float | None = None) -> Fault:
        """Return a fault of an attribute."""
        return Fault(f"{self.prim.GetPath()}.{name}", message, time)

    def has(self, *names: str) -> bool:
        """Return whether one of some attributes has an authored value."""
        return any(self.prim.GetAttribute(name).HasAuthoredValue() for name in names)

    def __iter__(self) -> Iterator[Snapshot]:
        return (self.at(time) for time in self.times or [None])

    @cached_property
    def first(self) -> Snapshot:
        return self.at(self.times[0] if self.times else None)

    @cached_property
    def points(self) -> list[float]:
        """Codes at which the points have samples."""
        return self.prim.GetAttribute("points").GetTimeSamples()

    def is_cut(self, before: Snapshot, after: Snapshot) -> bool:
        """Return whether the shot is cut between two times, by our notes."""
        cuts = notes_of(self.prim.GetStage()).get("cuts")
        noted = cuts if cuts and isinstance(cuts, Vt.IntArray) else ()
        return any(before.time.GetValue() < cut <= after.time.GetValue() for cut in noted)

    @property
    def moves(self) -> bool:
        """Whether its points have samples at more than one time."""
        return len(self.points) > 1

    @cached_property
    def still(self) -> Snapshot | None:
        """Hair in its rest pose; None where rest pose or hair is missing or invalid."""
        still = RestShape(self.prim, self.first.time)
        return still if still.sound and self.first.sound else None

    @cached_property
    def growth(self) -> np.ndarray:
        """Lengths of strands at rest over those at the first time, (c,); 1 where there is no rest."""
        if self.still is None:
            return np.ones(len(self.first.counts))
        return self.still.lengths / np.maximum(self.first.lengths, TINY)

    @cached_property
    def reference(self) -> Snapshot | None:
        """Hair in its own rest pose, else at its first time; None where it is invalid."""
        near = self.still is not None and REST[0] <= np.median(self.growth) <= REST[1]
        return self.still if near else self.first if self.first.sound else None


@dataclass(frozen=True)
class Scene:
    """Visible shapes of a stage.

    hair    curves of hair
    meshes  visible meshes
    skins   all meshes: the skin of hair may be invisible
    found   roots of hair on them, by its path, as far as they were searched
    """

    stage: Usd.Stage
    hair: list[Track]
    meshes: list[Track]
    skins: list[Track]
    found: "dict[Sdf.Path, Roots | None]" = field(default_factory=dict)

    @cached_property
    def bindings(self) -> dict[Sdf.Path, Binding]:
        """Bindings of meshes to skeletons; none for invalid skeletons."""
        try:
            return find_bindings(self.stage)
        except BadInput:
            return {}

    @cached_property
    def metres(self) -> np.ndarray:
        """Matrix from the world to metres with Y up, column vectors, (4, 4) float64."""
        return to_metres(self.stage)

    def place(self, mesh: Track, time: float | None) -> np.ndarray:
        """Return the points of a mesh in the world, moved by its skeleton if it has one, (n, 3) float64."""
        shape = mesh.at(time)
        binding = self.bindings.get(mesh.prim.GetPath())
        if binding is None or not len(shape.points):
            return shape.placed
        points = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(shape.points))
        transforms = binding.skeleton.ComputeSkinningTransforms(shape.time)
        binding.skinning.ComputeSkinnedPoints(transforms, points, shape.time)
        skeleton = UsdGeom.Xformable(binding.skeleton.GetPrim()).ComputeLocalToWorldTransform(shape.time)
        return np.array(points) @ np.array(skeleton)[:3, :3] + np.array(skeleton)[3, :3]

    def moves(self, mesh: Track) -> bool:
        """Return whether a mesh moves."""
        turned = any(space.TransformMightBeTimeVarying() for space in spaces_of(mesh.prim))
        return mesh.moves or turned or mesh.prim.GetPath() in self.bindings

    def roots(self, hair: Track) -> "Roots | None":
        """Find the roots of hair: on authored faces, else on the moving mesh that is nearest at the first time."""
        path = hair.prim.GetPath()
        if path not in self.found:
            self.found[path] = self.authored_roots(hair) or self._nearest_roots(hair)
        return self.found[path]

    def authored_roots(self, hair: Track) -> "Roots | None":
        """Find the mesh with the authored faces of the hair; the nearest of several."""
        return _best([roots for mesh in self.skins if hair.first.sound and (roots := _authored_on(self, hair, mesh))])

    def _nearest_roots(self, hair: Track) -> "Roots | None":
        if not (hair.first.sound and hair.moves) or hair.first.array("primvars:skinprim") is not None:
            return None
        moving = [mesh for mesh in self.meshes if self.moves(mesh)]
        meshes = moving or (self.meshes if len(self.meshes) == 1 else [])
        return _best([roots for mesh in meshes if (roots := _nearest_on(self, hair, mesh))])


def find_scene(stage: Usd.Stage) -> Scene:
    """Find the hair and meshes of a stage that are visible at its first time."""
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    hair = [Track(prim) for prim in prims if prim.IsA(UsdGeom.BasisCurves) and _is_drawn(prim)]
    skins = [Track(prim) for prim in prims if prim.IsA(UsdGeom.Mesh)]
    hair = [track for track in hair if len(track.first.counts) >= MANY or track.has(*OURS)]  # not a wire or a rope
    return Scene(stage, hair, [track for track in skins if _is_drawn(track.prim)], skins)


def _is_drawn(prim: Usd.Prim) -> bool:
    image = UsdGeom.Imageable(prim)
    shown = image and image.ComputeVisibility(Usd.TimeCode.EarliestTime()) != UsdGeom.Tokens.invisible
    return bool(shown and image.ComputePurpose() in RENDERED)


@dataclass(frozen=True)
class Roots:
    """Roots of strands on a mesh.

    scene, hair, mesh  scene, hair of the roots, and mesh under them
    strands            strands with known roots, (s,) int64
    corners            points of the mesh around each root, (s, 3) int64
    weights            of these, (s, 3) float64
    authored           whether the file states the faces; else they are the nearest at the first time
    """

    scene: Scene
    hair: Track
    mesh: Track
    strands: np.ndarray
    corners: np.ndarray
    weights: np.ndarray
    authored: bool

    def misses(self, hair: Snapshot, time: float | None, *, tips: bool = False) -> np.ndarray:
        """Return the distances of the roots, or tips, of hair from the skin at a time, (s,) [scene units]."""
        ends = (hair.tips if tips else hair.roots)[self.strands]
        on_skin = np.einsum("sk,skx->sx", self.weights, self.scene.place(self.mesh, time)[self.corners])
        return np.linalg.norm(hair.placed[ends] - on_skin, axis=1)

    def far(self, hair: Snapshot, time: float | None) -> np.ndarray:
        """Return the roots so far off their authored skin that a single one is a fault, (s,) bool."""
        return self.authored & (self.misses(hair, time) > FAR * self.reach)

    @cached_property
    def reach(self) -> float:
        """Largest accepted distance of a root from the skin [scene units]."""
        hair = self.hair.first
        ends = hair.placed[1:] - hair.placed[:-1]
        length = np.median(hair.per_strand(np.add, np.delete(np.linalg.norm(ends, axis=1), hair.tips[:-1])))
        return float(length) * (OFF if self.authored else LOOSE)


def _best(found: list[Roots]) -> Roots | None:
    misses = [np.median(roots.misses(roots.hair.first, roots.hair.first.code)) for roots in found]
    return found[int(np.argmin(misses))] if found else None


def _authored_on(scene: Scene, hair: Track, mesh: Track) -> Roots | None:
    faces = hair.first.array("primvars:skinprim")
    uv = hair.first.array("primvars:skinprimuv", 2)
    skin = mesh.first
    if faces is None or uv is None or not len(faces) == len(uv) == len(hair.first.counts) or not skin.triangles:
        return None
    known = (faces >= 0) & (faces < len(skin.counts))
    if known.mean() < MOST:
        return None
    corners = skin.corners.reshape(-1, 3)[faces[known].astype(np.int64)]
    inside = uv[known].astype(np.float64)  # so that weights sum to 1 also far from the origin
    weights = np.column_stack([1 - inside.sum(axis=1), inside])
    return Roots(scene, hair, mesh, np.flatnonzero(known), corners, weights, authored=True)


def _nearest_on(scene: Scene, hair: Track, mesh: Track) -> Roots | None:
    """Return the nearest places on a mesh to some of the roots at the first time of the hair."""
    skin = mesh.first
    if not skin.faces:
        return None
    strands = np.unique(np.linspace(0, len(hair.first.counts) - 1, PROBED).astype(np.int64))
    points = scene.place(mesh, hair.first.code)
    inner = np.maximum(skin.counts - 2, 0)  # triangles about the first corner of each face
    step = np.arange(inner.sum()) - np.repeat(np.cumsum(inner) - inner, inner)
    first = np.repeat(skin.roots, inner)
    triangles = skin.corners[np.stack([first, first + step + 1, first + step + 2], axis=1)].astype(np.int64)
    if not (np.isfinite(points).all() and len(triangles)):
        return None
    roots = hair.first.placed[hair.first.roots[strands]]
    size = max(1, BLOCK // len(triangles))
    found = [_nearest(roots[i : i + size], points[triangles]) for i in range(0, len(roots), size)]
    face, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Roots(scene, hair, mesh, strands, triangles[face], weights, authored=False)


def _nearest(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return for points (p, 3) the nearest of triangles (t, 3, 3), (p,) int64, and its corners' weights, (p, 3)."""
    points = points[:, None]
    a, b, c = np.moveaxis(triangles, 1, 0)
    e, f, d = b - a, c - a, points - a
    ee, ef, ff, de, df = ((one * other).sum(-1) for one, other in ((e, e), (e, f), (f, f), (d, e), (d, f)))
    area = ee * ff - ef * ef
    with np.errstate(divide="ignore", invalid="ignore"):
        v, w = (ff * de - ef * df) / area, (ee * df - ef * de) / area
    foot = np.stack([1 - v - w, v, w], axis=-1)  # of the perpendicular; NaN for triangles without area
    candidates = [np.where((foot >= 0).all(axis=-1, keepdims=True), foot, np.nan)]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        start = triangles[:, i]
        along = triangles[:, j] - start
        share = np.clip(((points - start) * along).sum(-1) / np.maximum((along * along).sum(-1), TINY), 0, 1)
        weights = np.zeros((*share.shape, 3))
        weights[..., i] = 1 - share
        weights[..., j] = share
        candidates.append(weights)
    stacked = np.stack(candidates)
    places = np.einsum("kptc,tcx->kptx", stacked, triangles)
    distances = np.nan_to_num(((places - points) ** 2).sum(axis=-1), nan=np.inf)
    best = distances.min(axis=0).argmin(axis=1)
    kind = distances[:, np.arange(len(points)), best].argmin(axis=0)
    return best, stacked[kind, np.arange(len(points)), best]
