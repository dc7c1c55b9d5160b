"""Hair at rest, and hair at one frame."""

from dataclasses import field

import numpy as np

from hairpipe.data.value import value


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
