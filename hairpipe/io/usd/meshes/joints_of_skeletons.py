"""Motion of the joints of UsdSkel skeletons."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.joint_motion import JointMotion
from hairpipe.io.mesh_cache.moving import sampled
from hairpipe.io.usd.meshes.blend_shapes import Names, name_weights, weights_at
from hairpipe.io.usd.meshes.skeleton import (
    Binding,
    filled,
    find_bindings,
    join_rigs,
    read_rig,
    turn_codes,
    weight_codes,
)
from hairpipe.io.usd.stage import columns, common_time, location, open_whole, place, shown, time_of, usd_faults
from hairpipe.plain_file import Absent

Queries = Sequence[UsdSkel.SkeletonQuery]


def read(path: Path, group: str | None, absent: Absent = "refuse") -> JointMotion:
    """Read the skeletons of the meshes at or under a prim, as `read_body` joins them; all of a stage without meshes.

    Raises BadInput where there are none, or nothing moves them.
    """
    with usd_faults(path):
        stage = open_whole(path, group, absent)
        session = stage.GetSessionLayer()
        session.startTimeCode = common_time(stage) or 0.0
        queries, animators, names = _find_skeletons(stage, group)
        rigs = [read_rig(query, 0) for query in queries]
        firsts = np.cumsum([0] + [len(rig.joints) for rig in rigs]).tolist()
        skeleton = join_rigs([replace(rig, first=first) for rig, first in zip(rigs, firsts, strict=False)])
        unbind = np.linalg.inv(np.concatenate([np.empty((0, 4, 4)), *(rig.world for rig in rigs)])) @ skeleton.rest
        turns = [codes for query in queries for codes in turn_codes(query)]
        weighed = [weight_codes(query) for query in animators]
        constant = {code for group in (*turns, *weighed) for code in group}
        codes = np.array(sorted(filled(sampled(turns)) | sampled(weighed) or constant))
        shapes = tuple(weights_at(animators, names))
        world = np.empty((len(codes), *unbind.shape))
        weights = np.empty((len(codes), len(shapes)))
        for sample, session.startTimeCode in enumerate(codes.tolist()):
            world[sample] = np.concatenate([np.empty((0, 4, 4)), *map(_pose, queries)]) @ unbind
            weights[sample] = [*weights_at(animators, names).values()]
    if not len(codes):
        right = "a Skeleton whose skel:animationSource has samples"
        raise BadInput("no animation moves the joints", where=location(animators[0].GetPrim()), right=right)
    return JointMotion(skeleton, world, codes, stage.GetTimeCodesPerSecond(), float(codes[0]), shapes, weights)


def _pose(query: UsdSkel.SkeletonQuery) -> np.ndarray:
    """Return the transforms of joints to metres at the time of the stage, (j, 4, 4)."""
    found = query.ComputeJointSkelTransforms(time_of(query.GetPrim()))
    if not found:
        raise BadInput("the joints have no transforms", where=location(query.GetPrim()), right="a value for each joint")
    return place(query.GetPrim()) @ np.array([columns(matrix) for matrix in found])


def _find_skeletons(stage: Usd.Stage, group: str | None) -> tuple[Queries, Queries, Names]:
    """Return the skeletons of joints, those of weights of blend shapes, and the names of the weights."""
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    skeletons = [UsdSkel.Skeleton(prim) for prim in prims if prim.IsA(UsdSkel.Skeleton)]
    if skeletons and not any(prim.IsA(UsdGeom.Mesh) for prim in prims):
        queries = [UsdSkel.Cache().GetSkelQuery(skeleton) for skeleton in skeletons]
        return queries, queries, {}
    if not skeletons and (lone := [prim for prim in prims if prim.IsA(UsdSkel.Animation)]):
        right = "a stage that refers to this file, with the Skeleton, whose skel:animationSource is the animation"
        raise BadInput(
            "the animation has no Skeleton, so that its joints at rest are unknown",
            where=location(lone[0]),
            right=right,
        )
    bindings = find_bindings(stage)
    animated = find_bindings(stage, shapes=True)
    meshes = shown(stage, group, UsdGeom.Mesh)
    if not any(mesh.GetPath() in animated for mesh in meshes):
        where = f"{stage.GetRootLayer().realPath} {group or ''}".rstrip()
        raise BadInput(
            "no mesh is bound to a Skeleton", where=where, right="skel:skeleton and joint influences, or blend shapes"
        )
    names = name_weights([UsdGeom.Mesh(mesh) for mesh in meshes], [animated.get(mesh.GetPath()) for mesh in meshes])
    return _skeletons_of(bindings, meshes), _skeletons_of(animated, meshes), names


def _skeletons_of(bindings: Mapping[Sdf.Path, Binding], meshes: Sequence[Usd.Prim]) -> Queries:
    """Return the skeleton of every mesh that has one, once."""
    found = [bindings[mesh.GetPath()].skeleton for mesh in meshes if mesh.GetPath() in bindings]
    return list({query.GetPrim().GetPath(): query for query in found}.values())
