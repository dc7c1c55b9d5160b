"""Strands as a file has them, before they are bound to a body."""

from dataclasses import field

import numpy as np

from hairpipe.data.value import value


@value
class Curves:
    """Strands of a file, root first.

    points   points of all strands, in order [m], (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    ids      ids in the file, otherwise indices of the curves; unique, (S,) int32
    held     whether the tip is held like the root, (S,) bool
    spare    number of control points at either end of a strand beyond the ends of the curve, (S,) int64
    rest     points of the rest shape, if the file has one [m], (p, 3) float64
    widths   of the strands at all points [m], (p,) float64
    time     time code at which an animated file was read
    root_uv  texture coordinates of the roots, (S, 2) float32
    groups   group of each strand, (S,) int32, and group_names: the names of groups 0, 1, ..., or none
    guides   whether a strand is a guide, (S,) bool
    colours  at all points, (p, 3) float32
    maps     values of strands by name, of primvars that have no other meaning, (S,) float64 each
    """

    points: np.ndarray
    offsets: np.ndarray
    ids: np.ndarray
    held: np.ndarray
    spare: np.ndarray
    rest: np.ndarray | None = None
    widths: np.ndarray | None = None
    time: float | None = None
    root_uv: np.ndarray | None = None
    groups: np.ndarray | None = None
    group_names: tuple[str, ...] = ()
    guides: np.ndarray | None = None
    colours: np.ndarray | None = None
    maps: dict[str, np.ndarray] = field(default_factory=dict)


def labels_of(groups: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
    """Return the label of the group of each strand, (S,) text; pure.

    groups  (S,) int32
    names   of groups 0, 1, ...; without names a group is labelled by its number
    """
    return np.array(names)[groups] if names else groups.astype(str)


def numbered(labels: np.ndarray) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return groups of strands, (S,) int32, and their names, from labels, (S,) text; pure.

    Labels that are all numbers are these numbers, without names; otherwise groups are numbered in the order of names.
    """
    known, groups = np.unique(labels, return_inverse=True)
    if all(label.lstrip("-").isdecimal() and len(label) < 10 for label in known.tolist()):
        return labels.astype(np.int32), ()
    return groups.astype(np.int32), tuple(known.tolist())
