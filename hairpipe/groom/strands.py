"""Strands on no body: straight, arched or curled, side by side, and tufts of several rows of them."""

from dataclasses import replace

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.geometry.rotations import frame_along
from hairpipe.groom.resampling import divide
from hairpipe.groom.settings import Tuft
from hairpipe.values import Groom
from hairpipe.values.random_streams import stream
from hairpipe.values.strand_arrays import NOWHERE, offsets_of

SEGMENTS = 50  # of a strand of which nothing is said
FINE = 64  # pieces of the parabola to a segment


def lay_strands(
    count: int,
    length: float,
    segments: int,
    direction: tuple[float, float, float],
    spacing: tuple[float, float, float],
    curl: Helix | None,
    arch: float,
) -> Groom:
    """Return equal strands of equal segments, the root of the first at the origin, not bound to a body.

    length     length of the polyline [m]: segments of length / segments each
    direction  direction from root to tip, of any length
    spacing    distance from one root to the next [m]
    arch       rise of a parabola over its span, towards +Y, or +Z for a direction along Y
    Raises BadInput if the direction is zero, or if a strand is curled and arched, or coarser than half a turn.
    """
    if not np.linalg.norm(direction) > 0.0:
        raise BadInput(f"direction = {list(direction)} has no length", right="any other vector")
    if curl and arch:
        raise BadInput("a strand is either curled or arched", right="curl, or arch = 0")
    frame = frame_along(np.array(direction) / np.linalg.norm(direction))
    shape = wound(curl, length, segments) if curl else arched(arch, length, segments)
    roots = np.arange(count)[:, None] * np.array(spacing)
    points = roots[:, None] + shape @ frame.T
    frames = np.concatenate([np.broadcast_to(frame, (count, 3, 3)), roots[:, :, None]], axis=2)
    return unbound(points, np.ascontiguousarray(frames))


def unbound(strands: np.ndarray, root_frames: np.ndarray) -> Groom:
    """Make a groom of strands, (s, n+1, 3) [m], with frames of their roots, (s, 3, 4): bound to nothing."""
    count, points, _ = strands.shape
    return Groom(
        points=strands.reshape(-1, 3),
        offsets=offsets_of(np.full(count, points)),
        ids=np.arange(count, dtype=np.int32),
        root_triangles=np.zeros(count, np.int32),
        root_barycentrics=np.tile(NOWHERE, (count, 1)),
        root_frames=root_frames,
        root_uv=np.zeros((count, 2), np.float32),
    )


def arched(arch: float, length: float, segments: int) -> np.ndarray:
    """Return points on a parabola x = 4 arch z (1 - z / span), (segments + 1, 3) [m]; chords are length / segments."""
    if not arch:
        return np.arange(segments + 1)[:, None] * np.array((0.0, 0.0, length / segments))
    z = np.linspace(0.0, 1.0, FINE * segments + 1)
    points = np.zeros((segments + 1, 3))
    divide(np.column_stack([4.0 * arch * z * (1.0 - z), np.zeros_like(z), z]), points)
    return points * (length / segments / np.linalg.norm(points[1]))


def gather_tuft(row: Groom, tuft: Tuft) -> Groom:
    """Return rows like this one, every strand turned about its root by a rotation of its own; pure."""
    from hairpipe.groom.sampling import joined_strands  # heavy, where nodes read the settings above

    step = np.array(tuft.apart)
    groom = joined_strands(tuple(moved(row, k * step) for k in range(tuft.rows)))
    count = len(groom.ids)
    about = stream(tuft.seed, "stray").normal(size=(count, 3)) * np.radians(tuft.stray) / np.sqrt(2.0)
    turns = rotations(about)
    roots = groom.root_frames[:, :, 3]
    strands = np.repeat(np.arange(count), np.diff(groom.offsets))
    points = roots[strands] + np.einsum("pij,pj->pi", turns[strands], groom.points - roots[strands])
    frames = np.concatenate([turns @ groom.root_frames[:, :, :3], roots[:, :, None]], axis=2)
    return replace(groom, points=points, root_frames=frames)


def moved(groom: Groom, shift: np.ndarray) -> Groom:
    frames = groom.root_frames.copy()
    frames[:, :, 3] += shift
    return replace(groom, points=groom.points + shift, root_frames=frames)


def rotations(vectors: np.ndarray) -> np.ndarray:
    """Return the rotations about vectors by their length [rad], (n, 3), as matrices (n, 3, 3): Rodrigues."""
    angles = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    sine = np.sinc(angles / np.pi)
    cosine = 0.5 * np.sinc(0.5 * angles / np.pi) ** 2
    return np.eye(3) + sine * cross + cosine * (cross @ cross)
