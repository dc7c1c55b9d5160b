"""Displacements of a mesh by weights: linear between the keys of a shape, from 0 on."""

import numpy as np

from hairpipe.data import BlendShapes, Body, Pose
from hairpipe.errors import BadInput


def displace(rest: Body, pose: Pose) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the bound mesh with its blend shapes [m], (n, 3), and its velocities [m/s], None where it is still. Pure.

    Raises BadInput where the pose has other weights than the body.
    """
    base = rest.mesh.points if rest.bound is None else rest.bound.points
    shapes = rest.shapes
    if shapes is None:
        return base, None
    weights = shapes.rest if pose.weights is None else pose.weights
    rates = np.zeros(len(weights)) if pose.weight_rates is None else pose.weight_rates
    if len(weights) != len(shapes.names):
        what = f"a pose of {len(weights)} weights, the body has {len(shapes.names)} blend shapes"
        raise BadInput(what, where="in.pose", right="a motion loaded for this body")
    shares, slopes = key_shares(shapes, weights)
    each = np.diff(shapes.rows)
    points = base.copy()
    drift = np.zeros_like(base)
    np.add.at(points, shapes.vertices, np.repeat(shares, each)[:, None] * shapes.offsets)
    np.add.at(drift, shapes.vertices, np.repeat(slopes * rates[shapes.shapes], each)[:, None] * shapes.offsets)
    return points, drift if rates.any() else None


def key_shares(shapes: BlendShapes, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the share of every key at weights (K,), and its slope over the weight, (m,) each. Pure.

    A shape of a mesh is linear between its keys and nothing at 0, and beyond the last keys as between the last two.
    """
    shares, slopes = np.zeros(len(shapes.places)), np.zeros(len(shapes.places))
    for shape, mesh in np.unique(np.stack([shapes.shapes, shapes.meshes], axis=1), axis=0):
        keys = np.flatnonzero((shapes.shapes == shape) & (shapes.meshes == mesh))
        order = np.argsort(shapes.places[keys])
        keys = np.insert(keys[order], np.searchsorted(shapes.places[keys[order]], 0.0), -1)  # -1: nothing, at 0
        places = np.where(keys < 0, 0.0, shapes.places[keys])
        at = int(np.clip(np.searchsorted(places, weights[shape], side="right") - 1, 0, len(keys) - 2))
        slope = 1.0 / (places[at + 1] - places[at])
        share = slope * (weights[shape] - places[at])
        for key, value, rate in ((keys[at], 1.0 - share, -slope), (keys[at + 1], share, slope)):
            if key >= 0:
                shares[key], slopes[key] = value, rate
    return shares, slopes
