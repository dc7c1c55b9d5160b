"""Motion of the joints of UsdSkel skeletons."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from hairpipe.errors import BadInput
from hairpipe.io.mesh_cache.joint_motion import JointMotion
from hairpipe.io.usd.meshes.skeleton import filled, find_bindings, has_blend_shapes, join_rigs, read_rig, turn_codes
from hairpipe.io.usd.stage import columns, common_time, location, open_stage, place, shown, time_of, usd_faults

BENT = 1e-4
"""Largest difference of a bind pose from rest that rounding explains."""


def read(path: Path, group: str | None) -> JointMotion:
    """Read the skeletons of the meshes at or under a prim, as `read_body` joins them; all of a stage without meshes.

    Raises BadInput where there are none, or nothing moves them. Warns of what a pose does not carry.
    """
    with usd_faults(path):
        stage = open_stage(path)
        session = stage.GetSessionLayer()
        session.startTimeCode = common_time(stage) or 0.0
        queries = _find_skeletons(stage, group)
        rigs = [read_rig(query, 0) for query in queries]
        if any(np.abs(np.array(rig.skin) - np.eye(4)).max() > BENT for rig in rigs):
            message = (
                "restTransforms are not bindTransforms: where skin bends, poses move it only nearly as the file does"
            )
            warnings.warn(f"{path}: {message} (load_mesh_cache reads its points)", stacklevel=2)
        firsts = np.cumsum([0] + [len(rig.joints) for rig in rigs]).tolist()
        skeleton = join_rigs([replace(rig, first=first) for rig, first in zip(rigs, firsts, strict=False)])
        unbind = np.linalg.inv(np.concatenate([rig.world for rig in rigs])) @ skeleton.rest
        codes = np.array(sorted(filled({code for query in queries for code in turn_codes(query)})))
        world = np.empty((len(codes), *unbind.shape))
        for sample, session.startTimeCode in enumerate(codes.tolist()):
            world[sample] = np.concatenate([_pose(query) for query in queries]) @ unbind
    if not len(codes):
        right = "a Skeleton whose skel:animationSource has samples"
        raise BadInput("no animation moves the joints", where=location(queries[0].GetPrim()), right=right)
    return JointMotion(skeleton, world, codes, stage.GetTimeCodesPerSecond(), float(codes[0]))


def _pose(query: UsdSkel.SkeletonQuery) -> np.ndarray:
    """Return the transforms of joints to metres at the time of the stage, (j, 4, 4)."""
    found = query.ComputeJointSkelTransforms(time_of(query.GetPrim()))
    if not found:
        raise BadInput("the joints have no transforms", where=location(query.GetPrim()), right="a value for each joint")
    return place(query.GetPrim()) @ np.array([columns(matrix) for matrix in found])


def _find_skeletons(stage: Usd.Stage, group: str | None) -> Sequence[UsdSkel.SkeletonQuery]:
    prims = list(stage.Traverse(Usd.TraverseInstanceProxies()))
    skeletons = [UsdSkel.Skeleton(prim) for prim in prims if prim.IsA(UsdSkel.Skeleton)]
    if skeletons and not any(prim.IsA(UsdGeom.Mesh) for prim in prims):
        return [UsdSkel.Cache().GetSkelQuery(skeleton) for skeleton in skeletons]
    bindings = find_bindings(stage)
    bound = [mesh for mesh in shown(stage, group, UsdGeom.Mesh) if mesh.GetPath() in bindings]
    if not bound:
        where = f"{stage.GetRootLayer().realPath} {group or ''}".rstrip()
        raise BadInput("no mesh is bound to a Skeleton", where=where, right="skel:skeleton and joint influences")
    for mesh in filter(has_blend_shapes, map(UsdGeom.Mesh, bound)):
        message = f"{mesh.GetPath()} has blend shapes, which are not in a pose: load_mesh_cache reads them"
        warnings.warn(message, stacklevel=2)
    found = [bindings[mesh.GetPath()].skeleton for mesh in bound]
    return list({query.GetPrim().GetPath(): query for query in found}.values())
