"""Hair at rest, at one frame and in files, what holds it, values at its points, and its lengths and widths."""

from dataclasses import field

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values.body import Mesh
from hairpipe.values.value import value

_BEYOND = 1.5  # lengths of a strand: largest distance of its points from its root


@value
class Groom:
    """Strands on the body at rest, root first, bound to the body; segments are of equal length
    unless those of a file are kept (`load_groom`, points = "file").

    points            points of all strands in order, each from the skin to the tip [m], (p, 3) float64
    offsets           strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    ids               unique ids of the strands, (S,) int32
    root_triangles    triangle of the body a strand grows from, (S,) int32
    root_barycentrics barycentric coordinates of the root in it, (S, 3) float64, rows sum to 1
    root_frames       rest frame of the root: columns tangent, bitangent, outward normal, origin [m], (S, 3, 4) float64
    root_uv           texture coordinates of the root, (S, 2) float32
    tip_triangles     triangle of the body that holds the tip, -1 if free, (S,) int32; if absent, all are free
    tip_barycentrics  barycentric coordinates of the tip in it, (S, 3) float64
    tip_frames        rest frame of the tip, like `root_frames`, (S, 3, 4) float64
    widths            widths at all points as read from a file, for drawing [m], (p,) float64
    groups            group of each strand in its file, (S,) int32
    group_names       names of groups 0, 1, ...; empty if they have none
    guides            strands that are guides in their file, (S,) bool
    colours           colours at all points as in their file, (p, 3) float32
    maps              values of strands by name: vertex maps of the scalp at their roots, primvars of their file, each
                      (S,) float64
    """

    points: np.ndarray
    offsets: np.ndarray
    ids: np.ndarray
    root_triangles: np.ndarray
    root_barycentrics: np.ndarray
    root_frames: np.ndarray
    root_uv: np.ndarray
    tip_triangles: np.ndarray | None = None
    tip_barycentrics: np.ndarray | None = None
    tip_frames: np.ndarray | None = None
    widths: np.ndarray | None = None
    groups: np.ndarray | None = None
    group_names: tuple[str, ...] = ()
    guides: np.ndarray | None = None
    colours: np.ndarray | None = None
    maps: dict[str, np.ndarray] = field(default_factory=dict)


@value
class Strands:
    """Hair at one frame, as drawn and exported; strands, order and counts are those of the groom.

    points      [m], (p, 3) float64: single precision has an error of 0.03 mm a kilometre from the origin
    velocities  [m/s], (p, 3) float32
    offsets     strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    diameter    of strands, their mean where they vary [m]
    widths      diameters at all points where they vary, (p,) float32 [m]
    """

    points: np.ndarray
    velocities: np.ndarray
    offsets: np.ndarray
    diameter: float
    widths: np.ndarray | None = None

    def widths_at_points(self) -> np.ndarray:
        """Return the diameters at all points [m], (p,) float32."""
        return np.full(len(self.points), self.diameter, np.float32) if self.widths is None else self.widths


@value
class Guidance:
    """Guides that every strand of a groom follows; see `choose_guides`.

    ids      ids of the guides of each strand, that of the largest weight first, (S, 3) int32
    weights  weights of these guides, rows sum to 1, (S, 3) float32
    rest     points of the groom as its guides rotate them; lengths of segments are those of the groom [m],
             (p, 3) float64
    """

    ids: np.ndarray
    weights: np.ndarray
    rest: np.ndarray


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


@value
class Ends:
    """Both ends of every strand at one frame, as rigid motions from the groom: x -> R x + t.

    Columns are those of R, then t [m], in the coordinates of the groom. A free tip is NaN; a tip that is held at a
    frame and free at the next is released at the first of the two.

    roots       (S, 3, 4) float64
    roots_rate  derivative of roots by time [1/s, m/s], same shape
    tips        motion of the last segment and its end, same shape
    tips_rate   derivative of tips by time [1/s, m/s], same shape
    """

    roots: np.ndarray
    roots_rate: np.ndarray
    tips: np.ndarray
    tips_rate: np.ndarray


@value
class Pins:
    """Places of pinned points of a groom at one frame, and the strength of their pins.

    points      index of every pinned point in the groom, ascending, (k,) int32
    positions   place to which the point is pulled [m], (k, 3) float64
    velocities  velocity of that place [m/s], (k, 3) float64
    frequency   natural frequency of a point about its place [Hz]
    damping     ratio of damping to critical damping
    among       number of points of the groom
    """

    points: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    frequency: float
    damping: float
    among: int


@value
class PointValues:
    """Values at the points of strands, for display; a name contains its unit, as in "depth [mm]".

    names    names of the K values
    values   one row per name, (K, p) float32
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    """

    names: tuple[str, ...]
    values: np.ndarray
    offsets: np.ndarray


@value
class Normals:
    """Normals of the hair volume at the points of its strands, for shading.

    vectors  unit normals; 0 where undefined, (p, 3) float32
    """

    vectors: np.ndarray


def segment_lengths(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the lengths of all segments [m], strand after strand, (P - S,) float64.

    points   root first, strand after strand [m], (P, 3)
    offsets  strand s owns points offsets[s]:offsets[s+1], (S + 1,)
    """
    return np.delete(_ways(points), offsets[1:-1] - 1)


def strand_lengths(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the length of every strand along its segments [m], (S,) float64; arguments as in `segment_lengths`."""
    ways = _ways(points)
    ways[offsets[1:-1] - 1] = 0.0
    return np.add.reduceat(ways, offsets[:-1])


def fractions_along(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return how far every point is along its strand, 0 at the root and 1 at the tip, (P,) float64; pure.

    Arguments as in `segment_lengths`; no strand is without length.
    """
    ways = np.concatenate([[0.0], _ways(points)])
    ways[offsets[:-1]] = 0.0
    along = np.cumsum(ways)
    counts = np.diff(offsets)
    roots = along[offsets[:-1]]
    lengths = along[offsets[1:] - 1] - roots
    return (along - np.repeat(roots, counts)) / np.repeat(lengths, counts)


def unequal(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the difference of the longest and the shortest segment of every strand [m], (S,) float64."""
    lengths = segment_lengths(points, offsets)
    starts = offsets[:-1] - np.arange(len(offsets) - 1)
    return np.maximum.reduceat(lengths, starts) - np.minimum.reduceat(lengths, starts)


def _ways(points: np.ndarray) -> np.ndarray:
    """Return the distances from each point to the next [m], those from tips to roots among them."""
    return np.linalg.norm(np.diff(points.astype(float), axis=0), axis=1)


DIAMETERS = "hairDiameter"
"""Attribute of the diameters at points in files whose widths are those of a picture."""
TAPER = 0.35
"""Part of a strand, at its tip, over which a drawn one narrows to nothing."""


def drawn_widths(diameters: np.ndarray, offsets: np.ndarray, hairs: float) -> np.ndarray:
    """Return the widths with which every strand covers the area of a number of hairs [m], (p,) float32; pure.

    A strand that represents more than one hair narrows to its tip, as the ends of its hairs do.

    diameters  of the strands at their points [m], (p,)
    offsets    strand s owns points offsets[s]:offsets[s+1], (S+1,)
    hairs      number of hairs that a strand represents; up to 1, widths are diameters
    """
    return (diameters * hairs * tapers(offsets) if hairs > 1.0 else diameters).astype(np.float32)


def tapers(offsets: np.ndarray) -> np.ndarray:
    """Return the widths of strands at their points over those at their roots, 0 at tips, (p,) float64; pure.

    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    """
    counts = np.diff(offsets)
    left = np.repeat(offsets[1:] - 1, counts) - np.arange(offsets[-1])
    return np.sqrt(np.minimum(left / np.repeat(TAPER * (counts - 1), counts), 1.0))


Driver = Mesh | Ends | None
"""The driver of the roots: a body or scripted ends; None: the roots are fixed."""


def check_driver(driver: Driver, groom: Groom) -> None:
    """Raise BadInput where the driver belongs to another groom."""
    bound = max(ends.max(initial=-1) for ends in (groom.root_triangles, groom.tip_triangles) if ends is not None)
    if isinstance(driver, Mesh) and bound >= len(driver.triangles):
        what = f"hair grows from triangle {bound} of a body that has {len(driver.triangles)}"
        raise BadInput(what, where="in.body", right="the body that the groom was grown on")
    if isinstance(driver, Ends) and len(driver.roots) != len(groom.ids):
        what = f"ends of {len(driver.roots)} strands, the groom has {len(groom.ids)}"
        raise BadInput(what, where="in.ends", right="ends driven of the same groom")


def lengths_at_points(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return half of the segments next to each point [m], (P,); 0 for strands that are not finite."""
    lengths = np.append(np.linalg.norm(np.diff(points, axis=0), axis=1), 0.0)
    lengths[offsets[1:] - 1] = 0.0
    shares = 0.5 * (lengths + np.roll(lengths, 1))
    return np.where(np.isfinite(shares), shares, 0.0)


def reach_of(points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the largest valid distance of the points of a strand from its root [m], (S,); 0 if it is not finite."""
    lengths = strand_lengths(points, offsets)
    return np.where(np.isfinite(lengths), _BEYOND * lengths, 0.0)
