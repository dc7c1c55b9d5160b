"""Visible hair and meshes of a stage over time, one frame of one shape in memory at a time."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from hairpipe.errors import BadInput
from hairpipe.io.usd.check.track import Track
from hairpipe.io.usd.meshes.skeleton import Binding, find_bindings
from hairpipe.io.usd.stage import RENDERED, to_metres

OURS = ("primvars:hairId", "primvars:pref", "primvars:skinprim", "velocities")
MANY = 20  # fewest curves that are hair


@dataclass(frozen=True)
class Scene:
    """Visible shapes of a stage.

    hair    curves of hair
    meshes  visible meshes
    skins   all meshes: the skin of hair may be invisible
    roots   roots of hair on them, by its path, as far as they were searched
    """

    stage: Usd.Stage
    hair: list[Track]
    meshes: list[Track]
    skins: list[Track]
    roots: dict[Sdf.Path, Any] = field(default_factory=dict)

    @cached_property
    def bindings(self) -> dict[Sdf.Path, Binding]:
        """Return the bindings of meshes to skeletons; none for invalid skeletons."""
        try:
            return find_bindings(self.stage)
        except BadInput:
            return {}

    @cached_property
    def metres(self) -> np.ndarray:
        """Return the matrix from the world to metres with Y up, column vectors, (4, 4) float64."""
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
        above = [mesh.prim]
        while above[-1].GetParent().IsA(UsdGeom.Xformable):
            above.append(above[-1].GetParent())
        turned = any(UsdGeom.Xformable(prim).TransformMightBeTimeVarying() for prim in above)
        return mesh.moves or turned or mesh.prim.GetPath() in self.bindings


def find_scene(stage: Usd.Stage) -> Scene:
    """Find the hair and meshes of a stage that are visible at its first time."""
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    hair = [Track(prim) for prim in prims if prim.IsA(UsdGeom.BasisCurves) and _is_drawn(prim)]
    skins = [Track(prim) for prim in prims if prim.IsA(UsdGeom.Mesh)]
    meshes = [track for track in skins if _is_drawn(track.prim)]
    return Scene(stage, [track for track in hair if _is_hair(track)], meshes, skins)


def _is_drawn(prim: Usd.Prim) -> bool:
    image = UsdGeom.Imageable(prim)
    shown = image and image.ComputeVisibility(Usd.TimeCode.EarliestTime()) != UsdGeom.Tokens.invisible
    return bool(shown and image.ComputePurpose() in RENDERED)


def _is_hair(track: Track) -> bool:
    """Return whether curves are hair, not a wire or a rope: many curves, or curves with attributes of hair."""
    return len(track.first.counts) >= MANY or any(track.prim.GetAttribute(name).HasAuthoredValue() for name in OURS)
