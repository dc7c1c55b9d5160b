"""UsdSkel: skeletons of a stage and the meshes they move, blend shapes with in-betweens, and their motion."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import sampled
from hairpipe.formats.rigging import ROUNDED, JointMotion, Key, jointed, rigid, unique_names
from hairpipe.formats.usd.stage import (
    checked,
    columns,
    common_time,
    location,
    open_whole,
    place,
    shown,
    time_of,
    transform_codes,
    usd_faults,
)
from hairpipe.plain_file import Absent
from hairpipe.values import Skeleton

REST = Usd.TimeCode.EarliestTime()


@dataclass(frozen=True)
class Binding:
    """Binding of a mesh to a skeleton."""

    skeleton: UsdSkel.SkeletonQuery
    skinning: UsdSkel.SkinningQuery


@dataclass(frozen=True)
class Rig:
    """Joints of one skeleton prim, and skinning from the bind pose to the rest pose.

    first    index of its first joint in the skeleton of the whole body
    joints   tokens such as "hips/spine/neck", J of them
    parents  index of the parent joint or -1, a parent before its children, (J,) int32
    world    joint-to-world at rest in metres, column vectors, (J, 4, 4) float64
    rest     the same without scale
    skin     bind pose to rest pose in the skeleton's space, row vectors, J matrices
    matrix   the skeleton's space to metres, column vectors, (4, 4) float64
    """

    first: int
    joints: tuple[str, ...]
    parents: np.ndarray
    world: np.ndarray
    rest: np.ndarray
    skin: Vt.Matrix4dArray
    matrix: np.ndarray

    @property
    def turns(self) -> np.ndarray:
        """Bind pose to rest pose [m], column vectors, (J, 4, 4); exactly 1 where they differ by rounding alone."""
        turns = self.matrix @ np.array([columns(m) for m in self.skin]) @ np.linalg.inv(self.matrix)
        return np.eye(4) + np.where(np.abs(turns - np.eye(4)).max(initial=0.0) > ROUNDED, turns - np.eye(4), 0.0)


def find_bindings(stage: Usd.Stage, shapes: bool = False) -> dict[Sdf.Path, Binding]:
    """Return the binding of every mesh that a skeleton moves by joints, or also by blend shapes.

    A skeleton is inherited by all prims under its root, and may have no joints.

    Raises BadInput if the joints of a skeleton do not form a tree.
    """
    cache = UsdSkel.Cache()
    found = {}
    predicate = Usd.TraverseInstanceProxies()
    for prim in stage.Traverse(predicate):
        root = UsdSkel.Root(prim)
        if root and cache.Populate(root, predicate):
            for binding in cache.ComputeSkelBindings(root, predicate):
                targets = binding.GetSkinningTargets()
                bound = [bool(s.GetJointIndicesPrimvar() or s.GetJointWeightsPrimvar()) for s in targets]
                query = _query(cache, binding.GetSkeleton(), any(bound) or not any(s.HasBlendShapes() for s in targets))
                pairs = zip(targets, bound, strict=True)
                skins = [skin for skin, is_bound in pairs if is_bound or (shapes and skin.HasBlendShapes())]
                found |= {skin.GetPrim().GetPath(): Binding(query, skin) for skin in skins}
    return found


def has_blend_shapes(mesh: UsdGeom.Mesh) -> bool:
    """Return whether a mesh names blend shapes."""
    return bool(UsdSkel.BindingAPI(mesh).GetBlendShapeTargetsRel().GetTargets())


def _query(cache: UsdSkel.Cache, skeleton: UsdSkel.Skeleton, jointed: bool) -> UsdSkel.SkeletonQuery:
    query = cache.GetSkelQuery(skeleton)
    if not query or (jointed and not query.GetJointOrder()):
        _, why = UsdSkel.Topology(skeleton.GetJointsAttr().Get() or []).Validate()
        what = f"the joints do not form a tree: {why or 'there are none'}"
        right = "each joint once, a parent before its children"
        raise BadInput(what, where=location(skeleton.GetPrim()), right=right)
    return query


def turn_codes(query: UsdSkel.SkeletonQuery) -> Iterator[list[float]]:
    """Yield the time codes of the transforms of a skeleton: of its parents, and of its joints."""
    animation = query.GetAnimQuery()
    yield from transform_codes(query.GetPrim())
    yield animation.GetJointTransformTimeSamples() if animation else []


def weight_codes(query: UsdSkel.SkeletonQuery) -> list[float]:
    """Return the time codes of all samples of the weights of blend shapes of a skeleton."""
    animation = query.GetAnimQuery()
    return animation.GetBlendShapeWeightTimeSamples() if animation else []


def filled(codes: set[float]) -> set[float]:
    """Return time codes of transforms with all whole ones between them: a cubic would not follow a turn."""
    return codes | {*np.arange(np.ceil(min(codes)), np.floor(max(codes)) + 1.0)} if codes else codes


def read_rig(query: UsdSkel.SkeletonQuery, first: int) -> Rig:
    """Read a skeleton at its restTransforms, or in the bind pose; BadInput where this does not fit, or is singular."""
    joints = tuple(query.GetJointOrder())
    where = location(query.GetPrim())
    if not query.HasBindPose():
        raise BadInput("bindTransforms do not fit the joints", where=where, right=f"{len(joints)} matrices")
    bind = query.GetJointWorldBindTransforms()
    matrix = place(query.GetPrim())
    if query.HasRestPose():
        rest = query.ComputeJointSkelTransforms(REST, True)
        skin = Vt.Matrix4dArray([_inverse(b, where) * r for b, r in zip(bind, rest, strict=True)])
    else:
        rest = bind
        skin = Vt.Matrix4dArray([Gf.Matrix4d(1)] * len(bind))
    parents = np.array(query.GetTopology().GetParentIndices(), np.int32)
    world = matrix @ np.array([columns(r) for r in rest])
    if not np.isfinite(world).all():
        raise BadInput("a joint transform is not finite", where=where, right="finite numbers")
    return Rig(first, joints, parents, world, rigid(world), skin, matrix)


def _inverse(matrix: Gf.Matrix4d, where: str) -> Gf.Matrix4d:
    if not np.isfinite(np.array(matrix)).all() or abs(matrix.GetDeterminant()) < 1e-30:
        raise BadInput("a bind transform cannot be inverted", where=where, right="matrices of full rank")
    return matrix.GetInverse()


def skin_at_rest(
    rig: Rig, skinning: UsdSkel.SkinningQuery, points: np.ndarray, joints: np.ndarray, weights: np.ndarray
) -> np.ndarray:
    """Return the points of a bound mesh in the skeleton's space at its rest pose, (n, 3), by `read_influences`."""
    moved = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32))
    influences = (
        Vt.IntArray.FromNumpy(np.ascontiguousarray(joints - rig.first, np.int32).ravel()),
        Vt.FloatArray.FromNumpy(np.ascontiguousarray(weights, np.float32).ravel()),
        joints.shape[1],
    )
    method = skinning.GetSkinningMethod()
    bind = skinning.GetGeomBindTransform(REST)
    if not UsdSkel.SkinPoints(method, bind, rig.skin, *influences, moved):
        right = "classicLinear or dualQuaternion"
        raise BadInput(f"cannot be skinned by the method {method}", where=location(skinning.GetPrim()), right=right)
    return np.array(moved, np.float64)


def read_influences(rig: Rig, skinning: UsdSkel.SkinningQuery, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the joints (n, k) int32 of n vertices, and their weights (n, k) float64, each row of sum 1.

    A vertex without weights follows the first root joint.

    Raises BadInput if counts, indices or weights are out of range.
    """
    where = location(skinning.GetPrim())
    influences = skinning.ComputeVaryingJointInfluences(n, REST) if skinning.HasJointInfluences() else None
    if influences is None:
        raise BadInput("jointIndices and jointWeights do not fit the points", where=where, right=f"{n} tuples")
    joints = np.array(influences[0], np.int64).reshape(n, -1)
    weights = np.array(influences[1], np.float64).reshape(n, -1)
    order = _joint_order(rig, skinning, where)
    if joints.min() < 0 or joints.max() >= len(order):
        raise BadInput("jointIndices has an index without a joint", where=where, right=f"0 to {len(order) - 1}")
    if not np.isfinite(weights).all() or weights.min() < 0:
        raise BadInput("jointWeights holds a negative or not finite weight", where=where, right="0 or more")
    bare = weights.sum(axis=1) == 0
    weights[bare, 0] = 1.0
    joints = (rig.first + np.where(bare[:, None], 0, order[joints])).astype(np.int32)
    return joints, weights / weights.sum(axis=1, keepdims=True)


def _joint_order(rig: Rig, skinning: UsdSkel.SkinningQuery, where: str) -> np.ndarray:
    named = skinning.GetJointOrder() or rig.joints
    unknown = [name for name in named if name not in rig.joints]
    if unknown:
        raise BadInput(f"skel:joints names {unknown[0]}", where=where, right="joints of the skeleton")
    return np.array([rig.joints.index(name) for name in named])


def join_rigs(rigs: Sequence[Rig]) -> Skeleton:
    """Join rigs, or none, into one skeleton, with joints named by the last part of their path where it is unique."""
    tokens = [token for rig in rigs for token in rig.joints]
    leaves = [token.rpartition("/")[2] for token in tokens]
    names = [leaf if leaves.count(leaf) == 1 else token for leaf, token in zip(leaves, tokens, strict=True)]
    names = [name if names.count(name) == 1 else f"{name}#{i}" for i, name in enumerate(names)]
    shifted = [np.where(rig.parents < 0, -1, rig.parents + rig.first) for rig in rigs]
    parents = np.concatenate([np.empty(0, np.int32), *shifted]).astype(np.int32)
    rest = np.concatenate([np.empty((0, 4, 4)), *(rig.rest for rig in rigs)])
    return jointed(names, parents, rest)


Names = dict[tuple[str, str], str]
"""Name of a weight by the path of its skeleton and its token in the file."""


def name_weights(meshes: Sequence[UsdGeom.Mesh], bindings: Sequence[Binding | None]) -> Names:
    """Return the names of the weights of bound meshes: the tokens, with the path where skeletons share one."""
    pairs = zip(meshes, bindings, strict=True)
    found = list(dict.fromkeys((skeleton_of(b), token) for m, b in pairs if b is not None for token in tokens_of(m)))
    return dict(zip(found, unique_names([token for _, token in found], [path for path, _ in found]), strict=True))


def skeleton_of(binding: Binding) -> str:
    return str(binding.skeleton.GetPrim().GetPath())


def tokens_of(mesh: UsdGeom.Mesh) -> list[str]:
    return list(UsdSkel.BindingAPI(mesh).GetBlendShapesAttr().Get() or ())


def read_keys(mesh: UsdGeom.Mesh, binding: Binding, names: Names, matrix: np.ndarray, n: int) -> list[Key]:
    """Return the keys of the blend shapes of a mesh of n points, moved by a matrix to the bound mesh (4, 4).

    Warns where names and targets do not fit each other. Raises BadInput where offsets or indices do not.
    """
    tokens = tokens_of(mesh)
    targets = UsdSkel.BindingAPI(mesh).GetBlendShapeTargetsRel().GetForwardedTargets()
    if len(tokens) != len(targets):
        what = f"skel:blendShapes has {len(tokens)} names for {len(targets)} blend shapes, which are ignored"
        warnings.warn(f"{location(mesh.GetPrim())}: {what}", stacklevel=2)
        return []
    keys = list[Key]()
    for token, path in zip(tokens, targets, strict=True):
        shape = UsdSkel.BlendShape.Get(mesh.GetPrim().GetStage(), path)
        if not shape:
            raise BadInput(f"{path} is not a BlendShape", where=location(mesh.GetPrim()), right="a prim BlendShape")
        places = [(1.0, shape.GetOffsetsAttr())]
        places += [(between.GetWeight(), between.GetAttr()) for between in shape.GetInbetweens()]
        given = shape.GetPointIndicesAttr().Get()
        for weight, attribute in places:
            offsets = checked(attribute.Get(), attribute, 3)
            whole = not given and len(offsets) > 0
            vertices = np.arange(n) if whole else np.array(given or (), np.int64)
            if len(offsets) != len(vertices) or (len(vertices) and not 0 <= vertices.min() <= vertices.max() < n):
                right = f"one for each of {len(vertices)} pointIndices of 0 to {n - 1}"
                raise BadInput(f"{len(offsets)} offsets", where=location(shape.GetPrim()), right=right)
            keys.append(Key(names[skeleton_of(binding), token], weight, vertices, offsets @ matrix[:3, :3].T))
    return keys


def weights_at(skeletons: Sequence[UsdSkel.SkeletonQuery], names: Names) -> dict[str, float]:
    """Return the weights of the animations of skeletons by name, at the time of the stage."""
    found = dict[str, float]()
    for query in skeletons:
        animation = query.GetAnimQuery()
        path = str(query.GetPrim().GetPath())
        tokens = list(animation.GetBlendShapeOrder()) if animation else []
        weights = animation.ComputeBlendShapeWeights(time_of(query.GetPrim())) if tokens else ()
        if len(weights) != len(tokens):
            where = location(animation.GetPrim())
            raise BadInput(f"there are {len(weights)} weights", where=where, right=f"{len(tokens)} of blendShapes")
        for token, weight in zip(tokens, weights, strict=True):
            if (path, str(token)) in names:
                found[names[path, str(token)]] = float(weight)
            else:
                found.setdefault(str(token), float(weight))
    return found


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
        what = "the animation has no Skeleton, so that its joints at rest are unknown"
        right = "a stage that refers to this file, with the Skeleton, whose skel:animationSource is the animation"
        raise BadInput(what, where=location(lone[0]), right=right)
    bindings = find_bindings(stage)
    animated = find_bindings(stage, shapes=True)
    meshes = shown(stage, group, UsdGeom.Mesh)
    if not any(mesh.GetPath() in animated for mesh in meshes):
        where = f"{stage.GetRootLayer().realPath} {group or ''}".rstrip()
        right = "skel:skeleton and joint influences, or blend shapes"
        raise BadInput("no mesh is bound to a Skeleton", where=where, right=right)
    names = name_weights([UsdGeom.Mesh(mesh) for mesh in meshes], [animated.get(mesh.GetPath()) for mesh in meshes])
    return _skeletons_of(bindings, meshes), _skeletons_of(animated, meshes), names


def _skeletons_of(bindings: Mapping[Sdf.Path, Binding], meshes: Sequence[Usd.Prim]) -> Queries:
    found = [bindings[mesh.GetPath()].skeleton for mesh in meshes if mesh.GetPath() in bindings]
    return list({query.GetPrim().GetPath(): query for query in found}.values())
