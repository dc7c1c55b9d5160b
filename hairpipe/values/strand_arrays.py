"""Strands in flat arrays: their offsets, some of them, and places along them as shares of their length."""

from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Groom, Strands
from hairpipe.values.groom import Curves, labels_of

Hair = TypeVar("Hair", Groom, Curves, Strands)
PER_POINT = ("points", "velocities", "rest", "widths", "colours")
PER_STRAND = (
    *("ids", "held", "spare", "groups", "guides", "root_triangles", "root_barycentrics", "root_frames", "root_uv"),
    *("tip_triangles", "tip_barycentrics", "tip_frames"),
)
MOST_NAMED = 5
NOWHERE = (1.0, 0.0, 0.0)  # barycentric coordinates of roots without a body
FREE = -1  # triangle of a tip that nothing holds
RISE = 5  # points over which the thickness grows from the root on


def offsets_of(counts: np.ndarray) -> np.ndarray:
    """Return the offsets of strands with given numbers of points, (S+1,) int32."""
    return np.concatenate(([0], np.cumsum(counts))).astype(np.int32)


def rows_of(begins: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return so many rows from each begin on, one range after another, (m,) int64; pure."""
    return np.arange(counts.sum()) + np.repeat(begins - (np.cumsum(counts) - counts), counts)


def take_strands(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points and offsets of some of the strands."""
    rows = points_of_strands(ids, offsets)
    return np.ascontiguousarray(points[rows], dtype=np.float64), offsets_of(np.diff(offsets)[ids])


def points_of_strands(strands: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the points of some strands, (n,), one strand after another, (m,) int64; pure."""
    return rows_of(offsets[strands], np.diff(offsets)[strands].astype(np.int64))


def take(hair: Hair, strands: np.ndarray, rows: np.ndarray | None = None, counts: np.ndarray | None = None) -> Hair:
    """Return some strands, in the order in which they are named, with the ids they have; pure.

    rows, counts  their points, strand after strand, and the number of points of each; by default all they have
    """
    rows = points_of_strands(strands, hair.offsets) if rows is None else rows
    counts = np.diff(hair.offsets)[strands] if counts is None else counts
    kept = dict.fromkeys(PER_POINT, rows) | dict.fromkeys(PER_STRAND, strands)
    values = {name: getattr(hair, name, None) for name in kept}
    some: dict[str, Any] = {
        name: np.ascontiguousarray(array[kept[name]]) for name, array in values.items() if array is not None
    }
    if not isinstance(hair, Strands):
        some["maps"] = {name: array[strands] for name, array in hair.maps.items()}
    return replace(hair, offsets=offsets_of(counts), **some)


def at_shares(values: np.ndarray, offsets: np.ndarray, strands: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return values of points, (P, 3), at shares 0..1 of the length of strands, linear between points, (n, 3); pure.

    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    strands  strand of each share, (n,)
    """
    segments = (np.diff(offsets) - 1)[strands]
    place = shares * segments
    below = np.minimum(place.astype(int), segments - 1)
    rest = (place - below)[:, None]
    begin = offsets[strands] + below
    return (1.0 - rest) * values[begin] + rest * values[begin + 1]


def shares_of(offsets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return whose every point is, and at which share of its length, (P,) each."""
    segments = np.diff(offsets) - 1
    strands = np.repeat(np.arange(len(segments)), segments + 1)
    return strands, (np.arange(len(strands)) - offsets[strands]) / segments[strands]


def thicknesses(offsets: np.ndarray, thickness: float) -> np.ndarray:
    """Return what every point keeps from the body [m], (P,): rising from 0 at the root to all of it at the fifth."""
    along = np.arange(offsets[-1]) - np.repeat(offsets[:-1], np.diff(offsets))
    return thickness * np.minimum(along, RISE) / RISE


def name_strands(ids: np.ndarray) -> str:
    """Return the first of some ids of strands and how many more there are, for a message."""
    named = ", ".join(map(str, ids[:MOST_NAMED]))
    return f"strands {named}" + (f" and {len(ids) - MOST_NAMED} more" if len(ids) > MOST_NAMED else "")


def members_of(groom: Groom, names: tuple[str, ...], where: str) -> np.ndarray:
    """Return which strands are in any of these groups, (S,) bool; pure.

    Raises BadInput at the place `where` for a name that no group of the groom has.
    """
    known = np.array([], str) if groom.groups is None else labels_of(groom.groups, groom.group_names)
    for name in names:
        if name not in known:
            has = ", ".join(f"'{label}'" for label in np.unique(known)) or "none"
            raise BadInput(f"the groom has no group '{name}'", where=where, right=f"its groups: {has}")
    return np.isin(known, names)


def is_bound(groom: Groom) -> bool:
    """Whether strands grow on a body; pure. Those of `groom/strands.py` do not."""
    return bool((groom.root_barycentrics != NOWHERE).any() or groom.root_triangles.any())
