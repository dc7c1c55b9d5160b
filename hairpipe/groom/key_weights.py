"""Key strands of every strand of a groom, and their weights; a node that names them is read without kernels."""

from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Groom, Guidance
from hairpipe.values.strand_arrays import take_strands

FOLLOWED = 3
"""Keys that a hair follows at most."""
CANDIDATES = 16  # nearest keys among which it finds them
_SAME_PLACE = 1e-9  # [m]; keys nearer than that to a root have it for themselves


class KeyWeights(NamedTuple):
    """Keys that hair follows, and their weights."""

    own: np.ndarray  # key that is this hair of the groom, -1: none, (S,) int64
    keys: np.ndarray  # keys that it follows, the nearest first, (S, FOLLOWED) int64
    weights: np.ndarray  # of these, rows sum to 1, (S, FOLLOWED)
    homes: np.ndarray  # hair of the groom whose root is nearest to that of each key, (K,) int64
    rest: np.ndarray  # points of the groom that the keys rotate [m], (P, 3)


def weigh_keys(keys: Groom, groom: Groom, parting: float, guidance: Guidance | None = None) -> KeyWeights:
    """Return the keys that the hairs of a groom follow; pure.

    With guidance they are its guides; BadInput if some of them are not among the keys. Without it they are the nearest
    by their roots, with weights 1/d^2, among keys whose direction at rest, root to tip, is within an angle `parting`
    [deg] of the hair's: hair does not follow keys beyond a parting. Without any, it is the one nearest in direction.
    """
    from scipy.spatial import KDTree  # here: a node that names this function is read without it

    theirs, roots = (some.points[some.offsets[:-1]] for some in (keys, groom))
    own = keys_among(groom, keys)
    homes = np.asarray(KDTree(roots).query(theirs)[1])
    homes[own[own >= 0]] = np.flatnonzero(own >= 0)
    if guidance is not None:
        return KeyWeights(own, places_of(guidance, keys, groom), guidance.weights.astype(float), homes, guidance.rest)
    found = KDTree(theirs).query(roots, k=min(CANDIDATES, len(theirs)))
    distances, nearest = (np.reshape(some, (len(roots), -1)) for some in found)
    cosines = np.einsum("si,ski->sk", _directions(groom), _directions(keys)[nearest])
    alike = cosines >= np.cos(np.radians(parting))
    lonely = ~alike.any(axis=1)
    alike[lonely, cosines[lonely].argmax(axis=1)] = True
    chosen = np.argsort(~alike, axis=1, kind="stable")[:, :FOLLOWED]
    weights = np.take_along_axis(alike / (distances**2 + _SAME_PLACE**2), chosen, axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    missing = ((0, 0), (0, FOLLOWED - chosen.shape[1]))
    chosen_keys = np.pad(np.take_along_axis(nearest, chosen, axis=1), missing)
    return KeyWeights(own, chosen_keys, np.pad(weights, missing), homes, groom.points)


def places_of(guidance: Guidance, keys: Groom, groom: Groom) -> np.ndarray:
    """Return the places of guides among the keys, (S, FOLLOWED) int64; pure.

    Raises BadInput where the guidance is that of another groom, or a guide is not a key.
    """
    if len(guidance.ids) != len(groom.ids) or guidance.rest.shape != groom.points.shape:
        raise BadInput("the guidance is not that of the groom", where="in.guidance", right="that of choose_guides")
    order = np.argsort(keys.ids)
    found = order[np.minimum(np.searchsorted(keys.ids, guidance.ids, sorter=order), len(order) - 1)]
    if not np.array_equal(keys.ids[found], guidance.ids):
        raise BadInput("a guide is not a key", where="in.guidance", right="in.keys: the keys of choose_guides")
    return found


def keys_among(groom: Groom, keys: Groom) -> np.ndarray:
    """Return which key every hair of a groom is: it has its id and its points; -1: none, (S,) int64."""
    found = np.full(len(groom.ids), -1)
    _, ours, theirs = np.intersect1d(groom.ids, keys.ids, return_indices=True)
    alike = np.diff(groom.offsets)[ours] == np.diff(keys.offsets)[theirs]
    ours, theirs = ours[alike], theirs[alike]
    (a, offsets), (b, _) = (take_strands(g.points, g.offsets, s) for g, s in ((groom, ours), (keys, theirs)))
    if len(ours):
        same = np.logical_and.reduceat((a == b).all(axis=1), offsets[:-1])
        found[ours[same]] = theirs[same]
    return found


def _directions(groom: Groom) -> np.ndarray:
    """Return where hair goes at rest, from root to tip, unit or 0, (S, 3)."""
    ways = groom.points[groom.offsets[1:] - 1] - groom.points[groom.offsets[:-1]]
    lengths = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.divide(ways, lengths, out=np.zeros_like(ways), where=lengths > 0.0)
