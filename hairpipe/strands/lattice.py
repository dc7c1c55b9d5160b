"""The spring network of a strand: Fig. 7b of Selle, Lentine, Fedkiw 2008, with the corrections below.

A strand of n segments is a chain of 2n+3 particles

    m_-1  q_-1  m_0  q_0  m_1  ...  q_n-1  m_n

The m lie on the axis, m_0 at the root; q_i is off the middle of segment i so that (m_i, q_i, m_i+1) is an equilateral
triangle. Along the chain every pair at distance one, two or three has a spring, and every four consecutive particles a
tetrahedron:

    offset 1   m-q                    extra edges (as strong as the hair's edges)
    offset 2   m-m edge, q-q bending
    offset 3   m-q                    torsion
    4 in a row                        altitude spring

so all couplings lie within three particles and one strand is one block-heptadiagonal matrix.

We differ from the paper:
- q turns about the axis by 72 degrees a segment, to the left for five segments, then to the right for five. Without a
  turn the network is floppy. At 90 degrees two altitude springs tie: near it, bending or twist makes the choice jump,
  and a strand with a Gamma beyond 60 has no equilibrium. Turned one way only it is softer when twisted with the turn
  than against it. Ten segments cover all directions equally.
- One segment (m_-1, q_-1, m_0) is buried and clamped. The network bends at the m_i, and m_0 represents only half a
segment of free hair: springs across it are twice as stiff. The free length is then exact for every roll of the strand.
- The first q lies opposite to the bend of the strand, or in a direction defined by the skin, not along an axis of the
world: a rotated groom is the same groom (`first_normals`). Curls rotate and stiffen their lattices, see `curl.py`.
- Curls are perturbed too, instead of using their own turns as triangles (Fig. 7a): those degenerate as curls stretch.
- Perturbed particles have 5 % of the mass instead of a third: off-axis mass slows torsion by orders of magnitude.

Tetrahedra of four particles have the formulas of Sec. 3.1, as the kernel of the springs does (`laws/altitude.py`).
"""

import numpy as np

from hairpipe.laws.settings import Construction

SECONDS, THIRDS = [1, 1, 2], [2, 3, 3]
"""Faces whose area vectors add up to u x v of two opposite edges."""


def area_vectors(fours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of six times the volume, and that volume, which may have either sign.

    fours    [m], (..., 4, 3)
    returns  (..., 4, 3) [m^2], (...) [m^3]
    """
    a, b, c, d = np.moveaxis(fours, -2, 0)
    n1, n2, n3 = np.cross(c - a, d - a), np.cross(d - a, b - a), np.cross(b - a, c - a)
    return np.stack([np.negative(n1 + n2 + n3), n1, n2, n3], axis=-2), np.sum(n1 * (b - a), axis=-1)


def altitude_vectors(areas: np.ndarray) -> np.ndarray:
    """Add u x v of opposite edges to area vectors, (..., 4, 3): (..., 7, 3) [m^2], as `altitude.py` has them."""
    return np.concatenate([areas, areas[..., SECONDS, :] + areas[..., THIRDS, :]], axis=-2)


CLAMPED = 3
REVERSAL = 5
TURN = np.deg2rad(Construction().turn)
HEIGHT = np.sqrt(3.0) / 2.0
_STRAIGHT = 1e-6
"""Distance of the middle of a straight strand from the line of its first segment, over its distance from the root."""


def perturb(axis: np.ndarray, normals: np.ndarray, turn: float | np.ndarray = TURN) -> np.ndarray:
    """Interleave the perturbed particles with the axis.

    axis     points of strands of n equal segments, root first [m], (s, n+1, 3)
    normals  normals of the first segments: directions of the first perturbed particles, see `first_normals`, (s, 3)
    turn     turn of the perturbed particles about the axis per segment [rad], for all or of every strand, (s, 1)
    returns  particles in the order of the chain [m], (s, 2n+3, 3)
    """
    axis = np.concatenate([2 * axis[:, :1] - axis[:, 1:2], axis], axis=1)
    edges = np.diff(axis, axis=1)
    lengths = np.linalg.norm(edges, axis=2, keepdims=True)
    off_axis = (axis[:, :-1] + axis[:, 1:]) / 2 + HEIGHT * lengths * _transported(edges / lengths, normals, turn)
    particles = np.empty((len(axis), 2 * axis.shape[1] - 1, 3))
    particles[:, ::2], particles[:, 1::2] = axis, off_axis
    return particles


def _transported(tangents: np.ndarray, first: np.ndarray, turn: float | np.ndarray) -> np.ndarray:
    """Transport unit normals, (s, 3), along the axis without twist, and turn them at every segment, (s, n+1, 3).

    The turn reverses its sense every REVERSAL segments.
    """
    normals = np.empty_like(tangents)
    normals[:, 0] = first
    for i in range(1, tangents.shape[1]):
        transported = transport(normals[:, i - 1], tangents[:, i - 1], tangents[:, i])
        sense = 1 - 2 * ((i - 1) // REVERSAL % 2)
        normals[:, i] = np.cos(turn) * transported + sense * np.sin(turn) * np.cross(tangents[:, i], transported)
    return normals


def first_normals(axis: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Return unit normals of the first segments of strands, which rotate with the strand and its root, (s, 3).

    axis    [m], (s, n+1, 3)
    frames  frames of the roots: columns tangent, bitangent, outward normal, (s, 3, 3 or more)

    They point away from the middle of the strand, if that is off the line of the first segment: the network of heavy
    overhanging hair is then usually as stable as the rod. For a straight strand, they follow the tangent of the skin,
    transported from the skin normal to the strand. A straight strand into the skin has no such direction: there it is
    the mirrored tangent, and discontinuous, like the smallest rotation to it.
    """
    edges = axis[:, 1] - axis[:, 0]
    along = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    middle = axis.mean(axis=1) - axis[:, 0]
    aside = middle - np.sum(middle * along, axis=1, keepdims=True) * along
    off = np.linalg.norm(aside, axis=1, keepdims=True)
    transported = transport(frames[:, :, 0], frames[:, :, 2], along)
    straight = off <= _STRAIGHT * np.linalg.norm(middle, axis=1, keepdims=True)
    return np.where(straight, transported, -aside / np.where(straight, 1.0, off))


def transport(vectors: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotate vectors by the smallest rotation that maps unit start to unit end; all (s, 3).

    For end = -start the smallest rotation is not unique, and the component along start is mirrored.
    """
    across = np.cross(start, end)
    cosine = np.sum(start * end, axis=1, keepdims=True)
    along = np.sum(across * vectors, axis=1, keepdims=True) * across / np.maximum(1 + cosine, 1e-12)
    transported = cosine * vectors + np.cross(across, vectors) + along
    transported -= np.sum(transported * end, axis=1, keepdims=True) * end
    return transported / np.linalg.norm(transported, axis=1, keepdims=True)


def masses(length: np.ndarray, line_density: np.ndarray, off_axis: float) -> np.ndarray:
    """Distribute the mass of a strand over its particles.

    length        of a segment [m], (s,)
    line_density  of the segments at the particles [kg/m], (s, 2n+3); off_axis  perturbed particles' share of the mass
    returns       [kg], (s, 2n+3); clamped particles have the mass that their segment would have
    """
    weights = np.tile([1 - off_axis, off_axis], line_density.shape[1] // 2 + 1)[:-1]
    weights[-1] /= 2
    dense = line_density.copy()
    dense[:, 2::2] = (
        line_density[:, 1:-1:2] + line_density[:, 2::2]
    ) / 2  # half of a point is of the segment before it
    return dense * length[:, None] * weights


def rest_lengths(particles: np.ndarray) -> np.ndarray:
    """Distances to the next three particles [m], (s, p, 3); zero past the end of the chain."""
    lengths = np.zeros((*particles.shape[:2], 3))
    for offset in (1, 2, 3):
        lengths[:, :-offset, offset - 1] = np.linalg.norm(particles[:, offset:] - particles[:, :-offset], axis=2)
    return lengths


def tetrahedra(particles: np.ndarray) -> np.ndarray:
    """Every four particles in a row [m], (s, p-3, 4, 3)."""
    return np.stack([particles[:, i : particles.shape[1] - 3 + i] for i in range(4)], axis=2)


def rest_heights(particles: np.ndarray) -> np.ndarray:
    """Return signed lengths of the seven altitude springs of every tetrahedron [m], (s, p, 7); zero where undefined.

    h = 6V / |N|; N is the area vector of a face (four) or u x v of two opposite edges (three), Sec. 3.1.
    """
    areas, volume = area_vectors(tetrahedra(particles))
    heights = np.zeros((*particles.shape[:2], 7))
    size = np.linalg.norm(altitude_vectors(areas), axis=3)
    np.divide(volume[:, :, None], size, out=heights[:, :-3], where=size > 0)
    return heights


def unbent(axis: np.ndarray, normals: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return strands with a share of the curvature, and the same first segments and lengths [m], (s, n+1, 3); pure.

    Each segment turns from the one before it by the share of its angle at the point between them, in the same direction
    in a frame that is transported along the strand without twist: a helix keeps its torsion.

    axis     points of strands [m], (s, n+1, 3)
    normals  unit normals of the first segments, (s, 3)
    shares   of the turn at every point, (s, n+1): where all are 1, a strand is the axis itself; 0 is straight
    """
    whole = (shares == 1.0).all(axis=1)
    if whole.all():
        return axis
    edges = np.diff(axis, axis=1)
    lengths = np.linalg.norm(edges, axis=2, keepdims=True)
    tangents = edges / lengths
    found = np.empty_like(tangents)
    found[:, 0] = now = tangents[:, 0]
    director = turned = normals
    for i in range(1, tangents.shape[1]):
        before = tangents[:, i - 1]
        after = tangents[:, i]
        cosine = np.sum(before * after, axis=1, keepdims=True)
        across = after - cosine * before
        sine = np.linalg.norm(across, axis=1, keepdims=True)
        across /= np.maximum(sine, np.finfo(float).tiny)
        angle = shares[:, i, None] * np.arctan2(sine, cosine)
        aside = np.sum(across * director, axis=1, keepdims=True) * turned
        aside += np.sum(across * np.cross(before, director), axis=1, keepdims=True) * np.cross(now, turned)
        following = np.cos(angle) * now + np.sin(angle) * aside
        following /= np.linalg.norm(following, axis=1, keepdims=True)
        director, turned = transport(director, before, after), transport(turned, now, following)
        found[:, i] = now = following
    bare = np.concatenate([axis[:, :1], axis[:, :1] + np.cumsum(lengths * found, axis=1)], axis=1)
    return np.where(whole[:, None, None], axis, bare)
