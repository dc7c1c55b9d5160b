"""Hair grown from the scalp of a body."""

import warnings

import numpy as np
from numba import njit, prange

from hairpipe.body.solid import Solid, solid_of
from hairpipe.data import Groom
from hairpipe.errors import BadInput
from hairpipe.groom.binding import root_frames
from hairpipe.groom.cutting import Cut, fitting
from hairpipe.groom.grow.closing import closed
from hairpipe.groom.grow.curling import wind
from hairpipe.groom.grow.rounding import Density
from hairpipe.groom.grow.seeding import seed_roots
from hairpipe.groom.grow.strand_axis import keep_out, lay, lift_off
from hairpipe.groom.grow.strand_layout import GAP, Layout, lay_out
from hairpipe.groom.grow.style import Style
from hairpipe.groom.importing import warn_of_fewer
from hairpipe.groom.painting.paint import Canvas, maps_at, vertex_coat
from hairpipe.groom.painting.painted import Paint
from hairpipe.groom.random_streams import stream
from hairpipe.groom.resampling import put, stride_on
from hairpipe.groom.strand_arrays import offsets_of
from hairpipe.kernels.vec3 import row
from hairpipe.spatial.triangle_tree import Tree
from hairpipe.spatial.triangles import Sites, site_uv

LONGEST_STEP = 0.0025  # along the axis of a strand, which is fine enough for ears and shoulders [m]
STEPS_A_TURN, STEPS_A_SEGMENT = 24, 3
OVERGROWTH = 1.25  # of the axis: the chords of curved hair are shorter than their arcs
LONGEST = 3.0  # [m]; hair of more is likelier a length in another unit
FEWEST_SEGMENTS_A_TURN = 4  # that still look like a curl


def grow(canvas: Canvas, style: Style, density: Paint | None, strands: int, cut: Cut) -> Groom:
    """Return hair grown on the scalp, every strand cut into equal segments that add up to its length.

    density   painted number of roots per area, relative to that of the scalp map alone
    strands   number of roots; hair shorter than the shortest segment is omitted
    cut       division into segments; by default determined by the length and curl of a strand
    Raises BadInput if no hair can grow.
    """
    mesh = canvas.body.mesh
    sites = seed_roots(mesh, scalp_density(canvas, density), strands, stream(canvas.seed, "roots"))
    frames = root_frames(mesh.points, mesh.triangles, *sites)
    layout = lay_out(canvas, style, sites, frames)
    ids = np.flatnonzero(layout.lengths >= cut.shortest).astype(np.int32)
    if len(ids) == 0:
        raise BadInput(
            f"all hair is shorter than {cut.shortest:g} m", where="length", right="longer, or a lesser `shortest`"
        )
    sites = Sites(*(array[ids] for array in sites))
    layout = Layout(*(array[ids] for array in layout))
    if layout.lengths.max() > LONGEST:
        warnings.warn(f"hair of up to {layout.lengths.max():.3g} m: is length in metres?", stacklevel=2)
    offsets = offsets_of(count_segments(layout, cut, ids) + 1)
    onset = style.curl.onset if style.curl else np.inf
    points = grow_strands(*solid_of(closed(mesh)), layout, style.bend, onset, offsets)
    maps = maps_at(canvas.body, sites)
    return Groom(points, offsets, ids, *sites, frames[ids], site_uv(mesh, sites), maps=maps)


def count_segments(layout: Layout, cut: Cut, ids: np.ndarray) -> np.ndarray:
    """Return how many segments every strand has, (S,); warn where they are fewer than asked, or than curls need."""
    turns = np.where(layout.radii > 0.0, np.hypot(2.0 * np.pi * layout.radii, layout.pitches), np.inf)
    wanted = cut.wanted(layout.lengths, fitting(layout.lengths, turns))
    most = cut.bearable(layout.lengths)
    if cut != Cut(shortest=cut.shortest):
        warn_of_fewer(ids[most < wanted], cut.shortest)
    counts = np.minimum(wanted, most)
    warn_of_zigzag(layout.lengths / turns, counts)
    return counts


def scalp_density(canvas: Canvas, paint: Paint | None) -> Density:
    """Return the density of roots: the map "scalp" of the body times what is painted."""
    scalp = vertex_coat(canvas.body, "scalp", "scalp")
    coat = None if paint is None else canvas.coat(paint, "density")
    return scalp if coat is None else lambda sites: scalp(sites) * coat(sites)


def warn_of_zigzag(turns: np.ndarray, segments: np.ndarray) -> None:
    """Warn where curls of so many turns, (S,), have too few segments, (S,), to be round."""
    needed = FEWEST_SEGMENTS_A_TURN * turns
    coarse = needed > segments
    if coarse.any():
        count = np.count_nonzero(coarse)
        most = int(np.ceil(needed[coarse].max()))
        warnings.warn(
            f"{count} curls have fewer than {FEWEST_SEGMENTS_A_TURN} segments per turn and are angular; "
            f"segments = {most} avoids this",
            stacklevel=3,
        )


@njit(cache=True)
def axis_step(length: float, segments: int, radius: float, pitch: float) -> float:
    """Return the step along the axis of a strand [m] that is fine enough for its segments and its curl."""
    step = min(LONGEST_STEP, length / (segments * STEPS_A_SEGMENT))
    return min(step, pitch / STEPS_A_TURN) if radius > 0.0 else step


@njit(cache=True, parallel=True)
def grow_strands(
    tree: Tree, normals: np.ndarray, layout: Layout, bend: float, onset: float, offsets: np.ndarray
) -> np.ndarray:
    """Return the points of strands of equal segments [m], (P, 3).

    tree, normals  those of the body's Solid: a parallel loop does not accept a tuple within a tuple
    bend           length over which a strand bends to the direction of its pull [m]
    onset          length over which the radius of its curl grows [m]
    offsets        strand s gets points offsets[s]:offsets[s+1], (S+1,) int32
    """
    points = np.empty((offsets[-1], 3))
    for s in prange(len(layout.roots)):  # Strands are independent: each thread writes points of its own.
        length, radius, pitch = layout.lengths[s], layout.radii[s], layout.pitches[s]
        segments = offsets[s + 1] - offsets[s] - 1
        step = axis_step(length, segments, radius, pitch)
        axis = np.empty((int(np.ceil(OVERGROWTH * length / step)) + 1, 3))
        put(axis, 0, row(layout.roots, s))
        solid = Solid(tree, normals)
        lay(solid, axis, row(layout.ahead, s), row(layout.combs, s), layout.layers[s], bend, step)
        if radius > 0.0:
            wind(axis, step, radius, pitch, onset, layout.phases[s])
        lift_off(solid, axis, GAP)
        strand = points[offsets[s] : offsets[s + 1]]
        stride_on(axis, length / segments, strand)
        keep_out(solid, strand, GAP)
    return points
