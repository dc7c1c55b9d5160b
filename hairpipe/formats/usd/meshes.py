"""Meshes of a stage: bodies at rest, animated meshes, and UsdSkel: skeletons, blend shapes, and their motion."""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, read_at, sampled
from hairpipe.formats.polygons import Polygons, join_polygons, triangulate, warn_of_cage
from hairpipe.formats.rigging import ROUNDED, JointMotion, Key, Part, join_parts, jointed, rigid, unique_names
from hairpipe.formats.usd.stage import (
    checked,
    columns,
    common_time,
    go_to,
    list_files,
    location,
    move,
    numbers,
    open_whole,
    place,
    read_time,
    shown,
    spaces_of,
    time_of,
    transform_codes,
    usd_faults,
)
from hairpipe.plain_file import Absent, with_folders
from hairpipe.values import Body, DualQuaternions, Mesh, Skeleton

REST = Usd.TimeCode.EarliestTime()
Queries = Sequence[UsdSkel.SkeletonQuery]


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
    rest = bind
    skin = Vt.Matrix4dArray([Gf.Matrix4d(1)] * len(bind))
    if query.HasRestPose():
        if not np.isfinite(np.array(bind)).all() or any(abs(b.GetDeterminant()) < 1e-30 for b in bind):
            raise BadInput("a bind transform cannot be inverted", where=where, right="matrices of full rank")
        rest = query.ComputeJointSkelTransforms(REST, True)
        skin = Vt.Matrix4dArray([b.GetInverse() * r for b, r in zip(bind, rest, strict=True)])
    parents = np.array(query.GetTopology().GetParentIndices(), np.int32)
    world = matrix @ np.array([columns(r) for r in rest])
    if not np.isfinite(world).all():
        raise BadInput("a joint transform is not finite", where=where, right="finite numbers")
    return Rig(first, joints, parents, world, rigid(world), skin, matrix)


def _read_rigs(queries: Queries) -> dict[Sdf.Path, Rig]:
    """Read each skeleton once, with its joints after those of the skeletons before."""
    rigs: dict[Sdf.Path, Rig] = {}
    for query in queries:
        if query.GetPrim().GetPath() not in rigs:
            rigs[query.GetPrim().GetPath()] = read_rig(query, sum(len(rig.joints) for rig in rigs.values()))
    return rigs


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
    if not UsdSkel.SkinPoints(method, skinning.GetGeomBindTransform(REST), rig.skin, *influences, moved):
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
    named = skinning.GetJointOrder() or rig.joints
    if unknown := [name for name in named if name not in rig.joints]:
        raise BadInput(f"skel:joints names {unknown[0]}", where=where, right="joints of the skeleton")
    order = np.array([rig.joints.index(name) for name in named])
    if joints.min() < 0 or joints.max() >= len(order):
        raise BadInput("jointIndices has an index without a joint", where=where, right=f"0 to {len(order) - 1}")
    if not np.isfinite(weights).all() or weights.min() < 0:
        raise BadInput("jointWeights holds a negative or not finite weight", where=where, right="0 or more")
    bare = weights.sum(axis=1) == 0
    weights[bare, 0] = 1.0
    joints = (rig.first + np.where(bare[:, None], 0, order[joints])).astype(np.int32)
    return joints, weights / weights.sum(axis=1, keepdims=True)


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
    """Return the keys of the blend shapes of a mesh of n points, moved by a matrix to the bound mesh (4, 4)."""
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


def weights_at(skeletons: Queries, names: Names) -> dict[str, float]:
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


def read_joints(path: Path, group: str | None, absent: Absent = "refuse") -> JointMotion:
    """Read the skeletons of the meshes at or under a prim, as `read_body` joins them; all of a stage without meshes."""
    with usd_faults(path):
        stage = open_whole(path, group, absent)
        session = stage.GetSessionLayer()
        session.startTimeCode = common_time(stage) or 0.0
        queries, animators, names = _find_skeletons(stage, group)
        rigs = list(_read_rigs(queries).values())
        skeleton = join_rigs(rigs)
        unbind = np.linalg.inv(np.concatenate([np.empty((0, 4, 4)), *(rig.world for rig in rigs)])) @ skeleton.rest
        turns = [codes for query in queries for codes in turn_codes(query)]
        weighed = [weight_codes(query) for query in animators]
        constant = {code for group in (*turns, *weighed) for code in group}
        codes = np.array(sorted(filled(sampled(turns)) | sampled(weighed) or constant))
        shapes = tuple(weights_at(animators, names))
        world = np.empty((len(codes), *unbind.shape))
        weights = np.empty((len(codes), len(shapes)))
        for sample, session.startTimeCode in enumerate(codes.tolist()):
            poses = [np.empty((0, 4, 4))]
            for query in queries:
                found = query.ComputeJointSkelTransforms(time_of(query.GetPrim()))
                if not found:
                    where = location(query.GetPrim())
                    raise BadInput("the joints have no transforms", where=where, right="a value for each joint")
                poses.append(place(query.GetPrim()) @ np.array([columns(matrix) for matrix in found]))
            world[sample] = np.concatenate(poses) @ unbind
            weights[sample] = [*weights_at(animators, names).values()]
    if not len(codes):
        right = "a Skeleton whose skel:animationSource has samples"
        raise BadInput("no animation moves the joints", where=location(animators[0].GetPrim()), right=right)
    return JointMotion(skeleton, world, codes, stage.GetTimeCodesPerSecond(), float(codes[0]), shapes, weights)


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


PER_VERTEX = (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying)
SKINNING = "skel:"  # prefix of the names of joint indices and weights
KNOWN = ("st", "displayColor", "displayOpacity")
SCALARS = (Sdf.ValueTypeNames.FloatArray, Sdf.ValueTypeNames.DoubleArray, Sdf.ValueTypeNames.HalfArray)


Maps = dict[str, np.ndarray]
"""Painted values of n vertices by name, each (n,) float64 in 0..1."""


def _read_mesh(prim: UsdGeom.Mesh, points: np.ndarray, matrix: np.ndarray) -> tuple[Polygons, Maps]:
    """Read faces without holes, texture coordinates and maps of a mesh, whose points a matrix takes to metres."""
    counts = numbers(prim.GetFaceVertexCountsAttr(), kind=np.int64)
    vertices = numbers(prim.GetFaceVertexIndicesAttr(), kind=np.int64)
    _check_faces(prim, counts, vertices, len(points))
    uv = _read_uv(prim, vertices, len(points))
    solid = _solid_faces(prim, len(counts))
    kept = np.repeat(solid, counts)
    points = move(matrix, points)
    vertices = vertices[kept]
    corners = triangulate(points[vertices], counts[solid])
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    if mirrored != (prim.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded):
        corners = corners[:, ::-1]
    triangles = np.ascontiguousarray(vertices[corners], np.int32)
    mesh = Mesh(points, triangles, uv=None if uv is None else np.ascontiguousarray(uv[kept][corners]))
    primvars = UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues()
    primvars = [p for p in primvars if not p.GetPrimvarName().startswith(SKINNING)]
    scalars = [p for p in primvars if p.GetInterpolation() in PER_VERTEX and p.GetTypeName() in SCALARS]
    maps = {p.GetPrimvarName(): _read_map(p, len(points)) for p in scalars if p.GetElementSize() == 1}
    unused = sorted({p.GetPrimvarName() for p in primvars} - {*maps, *KNOWN})
    if unused:
        message = f"primvars that are not used: {', '.join(unused)}"
        warnings.warn(f"{location(prim.GetPrim())}: {message}", stacklevel=2)
    kept = np.flatnonzero(solid)
    return Polygons(mesh, np.repeat(kept, counts[kept] - 2)), maps


def warn_of_scheme(prim: UsdGeom.Mesh) -> None:
    """Warn of an authored subdivision scheme that makes another surface; catmullClark by default may not be meant."""
    scheme = prim.GetSubdivisionSchemeAttr()
    if scheme.HasAuthoredValue() and scheme.Get() in (UsdGeom.Tokens.catmullClark, UsdGeom.Tokens.loop):
        points = numbers(prim.GetPointsAttr(), 3)
        counts = numbers(prim.GetFaceVertexCountsAttr(), kind=np.int64)
        vertices = numbers(prim.GetFaceVertexIndicesAttr(), kind=np.int64)
        _check_faces(prim, counts, vertices, len(points))
        warn_of_cage(location(prim.GetPrim()), points, counts, vertices, scheme.Get())


def _check_faces(prim: UsdGeom.Mesh, counts: np.ndarray, vertices: np.ndarray, n: int) -> None:
    where = location(prim.GetPrim())
    if not (n and len(counts)):
        raise BadInput("the mesh has no points or no faces", where=where, right="at least one face")
    if counts.min() < 3:
        raise BadInput(f"face {np.argmin(counts)} has {counts.min()} corners", where=where, right="3 or more")
    if counts.sum() != len(vertices):
        right = f"the sum of faceVertexCounts, {counts.sum()}"
        raise BadInput(f"faceVertexIndices has {len(vertices)} elements", where=where, right=right)
    if vertices.min() < 0 or vertices.max() >= n:
        bad = vertices[(vertices < 0) | (vertices >= n)][0]
        raise BadInput(f"faceVertexIndices names point {bad}", where=where, right=f"0 to {n - 1}")


def _solid_faces(prim: UsdGeom.Mesh, count: int) -> np.ndarray:
    """Return which faces are not holes, (count,) bool."""
    holes = numbers(prim.GetHoleIndicesAttr(), kind=np.int64)
    where = location(prim.GetPrim())
    if len(holes) and (holes.min() < 0 or holes.max() >= count):
        raise BadInput("holeIndices has an index without a face", where=where, right=f"0 to {count - 1}")
    solid = np.ones(count, bool)
    solid[holes] = False
    if not solid.any():
        raise BadInput("all faces are holes", where=where, right="at least one face")
    return solid


def _read_uv(prim: UsdGeom.Mesh, vertices: np.ndarray, n: int) -> np.ndarray | None:
    """Return the texture coordinates `st` of the face corners, (c, 2) float32; None, with a warning, for others."""
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    if not primvar.HasValue():
        return None
    values = _flat(primvar, 2).astype(np.float32)
    is_vertex = primvar.GetInterpolation() in PER_VERTEX
    try:
        _check_count(primvar, values, n if is_vertex else len(vertices))
    except BadInput as fault:
        message = f"{fault.where} {fault.what}, not {fault.right}: the mesh is read without texture coordinates"
        warnings.warn(message, stacklevel=3)
        return None
    return values[vertices] if is_vertex else values


def _read_map(primvar: UsdGeom.Primvar, n: int) -> np.ndarray:
    values = _flat(primvar, 1)
    _check_count(primvar, values, n)
    if values.min() < 0 or values.max() > 1:
        name = primvar.GetPrimvarName()
        warnings.warn(f"map {name} spans {values.min():g} to {values.max():g}; clipped to 0..1", stacklevel=2)
    return values.clip(0, 1)


def _flat(primvar: UsdGeom.Primvar, columns: int) -> np.ndarray:
    return checked(primvar.ComputeFlattened(time_of(primvar.GetAttr().GetPrim())), primvar.GetAttr(), columns)


def _check_count(primvar: UsdGeom.Primvar, values: np.ndarray, right: int) -> None:
    if len(values) != right:
        where = f"{location(primvar.GetAttr().GetPrim())}.{primvar.GetName()}"
        right_count = f"{right} for {primvar.GetInterpolation()} interpolation"
        raise BadInput(f"has {len(values)} elements", where=where, right=right_count)


def read_body(path: Path, prim: str | None = None, time: float | None = None, absent: Absent = "refuse") -> Body:
    """Read the meshes of a stage as one body at rest, with the UsdSkel skeletons that move them.

    Polygons are triangulated. Float primvars on vertices become maps, `st` texture coordinates; invisible meshes and
    those of purpose proxy or guide are omitted. Bound meshes are in the rest pose of their skeleton, others in their
    pose at one time; without any skeleton the body has no joints.

    prim    path of a mesh or of a parent of meshes; by default the whole stage
    time    time code; by default the first at which all meshes and curves have samples, and a warning if the body moves
    absent  whether absent files of the stage are refused, or warned of

    Raises BadInput if the file, or what it says, cannot be used; the message names the prim.
    """
    with usd_faults(path):
        stage = open_whole(path, prim, absent)
        go_to(stage, time)
        meshes = [UsdGeom.Mesh(p) for p in shown(stage, prim, UsdGeom.Mesh)]
        bindings = find_bindings(stage)
        rigs = _read_rigs([bindings[mesh.GetPath()].skeleton for mesh in meshes if mesh.GetPath() in bindings])
        animated = find_bindings(stage, shapes=True)
        animators = [animated.get(mesh.GetPath()) for mesh in meshes]
        names = name_weights(meshes, animators)
        parts = list[Part]()
        centres, dual = list[np.ndarray](), list[np.ndarray]()
        for mesh, animator in zip(meshes, animators, strict=True):
            binding = bindings.get(mesh.GetPath())
            part = _read_part(mesh, binding, rigs, animator, names)
            parts.append(part)
            rig = None if binding is None else rigs[binding.skeleton.GetPrim().GetPath()]
            centres.append(np.zeros(3) if rig is None else rig.matrix[:3, 3])
            # Dual quaternions bend the vertices of several joints.
            is_dual = binding is not None and binding.skinning.GetSkinningMethod() == UsdSkel.Tokens.dualQuaternion
            heaviest = np.take_along_axis(part.joints, part.weights.argmax(axis=1)[:, None], axis=1) if is_dual else 0
            dual.append(is_dual & ((part.joints != heaviest) & (part.weights > 0.0)).any(axis=1))
        for mesh in meshes:
            warn_of_scheme(mesh)
        time = read_time([mesh.GetPrim() for mesh in meshes if mesh.GetPath() not in bindings], time)
    turns = np.concatenate([np.empty((0, 4, 4)), *(rig.turns for rig in rigs.values())])
    blended = np.flatnonzero(np.concatenate(dual)).astype(np.int32)
    about = np.repeat(centres, [len(part.bound) for part in parts], axis=0)[blended]
    quaternions = DualQuaternions(blended, about) if len(blended) else None
    return join_parts(parts, join_rigs(list(rigs.values())), turns, {}, time, quaternions)


def _read_part(
    mesh: UsdGeom.Mesh, binding: Binding | None, rigs: dict[Sdf.Path, Rig], animator: Binding | None, names: Names
) -> Part:
    """Read a mesh, which a binding to a skeleton moves, and blend shapes, which another may animate."""
    points = numbers(mesh.GetPointsAttr(), 3)
    n = len(points)
    if binding is None:
        if rigs:
            warnings.warn(f"{mesh.GetPath()} is not bound to a skeleton, and follows the first joint", stacklevel=2)
        (triangles, _), maps = _read_mesh(mesh, points, place(mesh.GetPrim()))
        k = min(len(rigs), 1)
        joints = np.zeros((n, k), np.int32)
        weights = np.ones((n, k))
        unturn = np.linalg.inv(next(iter(rigs.values())).turns[0]) if rigs else np.eye(4)
        matrix = unturn @ place(mesh.GetPrim())
        bound = move(unturn, triangles.points)
    else:
        rig = rigs[binding.skeleton.GetPrim().GetPath()]
        joints, weights = read_influences(rig, binding.skinning, n)
        rest = skin_at_rest(rig, binding.skinning, points, joints, weights)
        (triangles, _), maps = _read_mesh(mesh, rest, rig.matrix)
        matrix = rig.matrix @ columns(binding.skinning.GetGeomBindTransform(REST))
        bound = move(matrix, points)
    keys = list[Key]()
    has_shapes = UsdSkel.BindingAPI(mesh).GetBlendShapeTargetsRel().GetTargets()
    if has_shapes and animator is not None:
        keys = read_keys(mesh, animator, names, matrix, n)
    elif has_shapes:
        message = f"{mesh.GetPath()} has blend shapes without a Skeleton to animate them, which are ignored"
        warnings.warn(message, stacklevel=3)
    return Part(triangles, maps, joints, weights, bound, keys)


def read_moving(path: Path, prim: str | None, instant: Instant, absent: Absent = "refuse") -> Polygons:
    """Read the visible meshes at or under a prim, or those that a pattern names, at an instant."""
    with usd_faults(path):
        return read_at(recall(MovingMeshes, path, prim, absent), instant)


class MovingMeshes:
    """Samples of the meshes of a stage in metres with Y up, see `animated_meshes.Samples`."""

    def __init__(self, path: Path, prim: str | None, absent: Absent = "refuse") -> None:
        self.stage = open_whole(path, prim, absent)
        self.files = with_folders(list_files(path))
        self.meshes = [UsdGeom.Mesh(p) for p in shown(self.stage, prim, UsdGeom.Mesh)]
        _refuse_instancers(self.stage, self.meshes, prim)
        bindings = find_bindings(self.stage, shapes=True)
        self.bindings = [bindings.get(mesh.GetPath()) for mesh in self.meshes]
        self.rate = self.stage.GetTimeCodesPerSecond()
        self.codes = self._find_codes()
        self.own = [self._has_velocities(*pair) for pair in zip(self.meshes, self.bindings, strict=True)]
        self._go_to(self.codes[0])
        self.polygons = [_polygons(mesh) for mesh in self.meshes]
        for mesh in self.meshes:
            warn_of_scheme(mesh)

    def shape(self, sample: int) -> Polygons:
        self._go_to(self.codes[sample])
        pairs = zip(self.meshes, self.bindings, strict=True)
        return join_polygons([_read_mesh(mesh, *_points(mesh, binding))[0] for mesh, binding in pairs])

    def sample(self, sample: int) -> list[Points]:
        """Read the points of the meshes at a sample; BadInput where polygons are not those of the first one."""
        self._go_to(self.codes[sample])
        found = list[Points]()
        for mesh, binding, has, first in zip(self.meshes, self.bindings, self.own, self.polygons, strict=True):
            if any(not np.array_equal(*pair) for pair in zip(_polygons(mesh), first, strict=True)):
                where = f"{location(mesh.GetPrim())} at time code {self.codes[sample]:g}"
                right = f"those of time code {self.codes[0]:g} at all times"
                raise BadInput("the polygons have changed", where=where, right=right)
            points, matrix = _points(mesh, binding)
            velocities = numbers(mesh.GetVelocitiesAttr(), 3) @ matrix[:3, :3].T if has else None
            if velocities is not None and len(velocities) != len(points):
                where = f"{location(mesh.GetPrim())} at time code {self.codes[sample]:g}"
                raise BadInput(f"there are {len(velocities)} velocities", where=where, right=f"{len(points)}")
            found.append((move(matrix, points), velocities))
        return found

    def _go_to(self, code: float) -> None:
        self.stage.GetSessionLayer().startTimeCode = code

    def _has_velocities(self, mesh: UsdGeom.Mesh, binding: Binding | None) -> bool:
        """Return whether velocities are used: in a moving space or on a skeleton, they are not all of the motion."""
        moves = any(space.TransformMightBeTimeVarying() for space in spaces_of(mesh.GetPrim()))
        return mesh.GetVelocitiesAttr().HasValue() and binding is None and not moves

    def _find_codes(self) -> np.ndarray:
        """Return the time codes of all samples of points, of transforms above them, and of their skeletons."""
        points = list[Sequence[float]]()
        turns = list[Sequence[float]]()
        for mesh, binding in zip(self.meshes, self.bindings, strict=True):
            points += mesh.GetPointsAttr().GetTimeSamples(), mesh.GetVelocitiesAttr().GetTimeSamples()
            turns += transform_codes(mesh.GetPrim())
            if binding is not None:
                turns += turn_codes(binding.skeleton)
                points.append(weight_codes(binding.skeleton))
        constant = {code for group in (*points, *turns) for code in group}
        return np.array(sorted(sampled(points) | filled(sampled(turns)) or constant or {0.0}))


def _polygons(mesh: UsdGeom.Mesh) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the sizes and corners of the polygons, and the number of points, at the time of the stage."""
    sizes = numbers(mesh.GetFaceVertexCountsAttr(), kind=np.int64)
    return sizes, numbers(mesh.GetFaceVertexIndicesAttr(), kind=np.int64), len(numbers(mesh.GetPointsAttr(), 3))


def _points(mesh: UsdGeom.Mesh, binding: Binding | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n, 3) in a space, and its matrix to metres (4, 4), at the time of the stage."""
    points = numbers(mesh.GetPointsAttr(), 3)
    if binding is None:
        return points, place(mesh.GetPrim())
    time = time_of(mesh.GetPrim())
    moved = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, np.float32))
    where = location(mesh.GetPrim())
    if binding.skinning.HasBlendShapes() and binding.skeleton.GetAnimQuery():
        _blend(mesh, binding, moved, time)
    if not binding.skinning.HasJointInfluences():
        return np.array(moved, np.float64), place(mesh.GetPrim())
    skeleton = binding.skeleton.ComputeSkinningTransforms(time)
    if not skeleton:
        raise BadInput("the joints have no transforms", where=where, right="a rest or bind pose, or an animation")
    matrix = place(binding.skeleton.GetPrim())
    if binding.skinning.IsRigidlyDeformed():
        rigid = binding.skinning.ComputeSkinnedTransform(skeleton, time)
        return np.array(moved, np.float64), matrix @ columns(rigid)
    if not binding.skinning.ComputeSkinnedPoints(skeleton, moved, time):
        raise BadInput("the mesh cannot be skinned", where=where, right="joint influences that fit points and joints")
    return np.array(moved, np.float64), matrix


def _blend(mesh: UsdGeom.Mesh, binding: Binding, points: Vt.Vec3fArray, time: Usd.TimeCode) -> None:
    shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(mesh))
    weights = binding.skeleton.GetAnimQuery().ComputeBlendShapeWeights(time)
    mapper = binding.skinning.GetBlendShapeMapper()
    weights = mapper.Remap(weights) if mapper else weights
    found = shapes.ComputeSubShapeWeights(weights)
    offsets = shapes.ComputeSubShapePointOffsets()
    if not found or not shapes.ComputeDeformedPoints(*found, shapes.ComputeBlendShapePointIndices(), offsets, points):
        right = "offsets and pointIndices that fit the points"
        raise BadInput("the blend shapes cannot be applied", where=location(mesh.GetPrim()), right=right)


def _refuse_instancers(stage: Usd.Stage, meshes: Sequence[UsdGeom.Mesh], prim: str | None) -> None:
    """Refuse a PointInstancer above a mesh, or among all shapes of the stage where all are read."""
    found = [p for p in stage.Traverse(Usd.TraverseInstanceProxies()) if p.IsA(UsdGeom.PointInstancer)]
    for instancer in found:
        if prim is None or any(mesh.GetPath().HasPrefix(instancer.GetPath()) for mesh in meshes):
            right = "its instances as meshes, or a group without it"
            raise BadInput("is a PointInstancer, which is not read", where=location(instancer), right=right)
