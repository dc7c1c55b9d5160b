"""Blend shapes of UsdSkel, with in-betweens, and the weights of an animation."""

import warnings
from collections.abc import Sequence

import numpy as np
from pxr import UsdGeom, UsdSkel

from hairpipe.errors import BadInput
from hairpipe.io.rigging import Key, unique_names
from hairpipe.io.usd.meshes.skeleton import Binding
from hairpipe.io.usd.stage import checked, location, time_of

Names = dict[tuple[str, str], str]
"""Name of a weight by the path of its skeleton and its token in the file."""


def name_weights(meshes: Sequence[UsdGeom.Mesh], bindings: Sequence[Binding | None]) -> Names:
    """Return the names of the weights of bound meshes: the tokens, with the path where skeletons share one."""
    pairs = zip(meshes, bindings, strict=True)
    found = list(dict.fromkeys((skeleton_of(b), token) for m, b in pairs if b is not None for token in tokens_of(m)))
    return dict(zip(found, unique_names([token for _, token in found], [path for path, _ in found]), strict=True))


def skeleton_of(binding: Binding) -> str:
    """Return the path of the skeleton that animates a mesh."""
    return str(binding.skeleton.GetPrim().GetPath())


def tokens_of(mesh: UsdGeom.Mesh) -> list[str]:
    """Return the names of the blend shapes of a mesh."""
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
        for place, attribute in places:
            offsets = checked(attribute.Get(), attribute, 3)
            whole = not given and len(offsets) > 0
            vertices = np.arange(n) if whole else np.array(given or (), np.int64)
            if len(offsets) != len(vertices) or (len(vertices) and not 0 <= vertices.min() <= vertices.max() < n):
                right = f"one for each of {len(vertices)} pointIndices of 0 to {n - 1}"
                raise BadInput(f"{len(offsets)} offsets", where=location(shape.GetPrim()), right=right)
            keys.append(Key(names[skeleton_of(binding), token], place, vertices, offsets @ matrix[:3, :3].T))
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
