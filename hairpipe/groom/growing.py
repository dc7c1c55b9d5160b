"""Hair grown from the scalp of a body."""

import warnings

import numpy as np
from numba import njit, prange

from hairpipe.body.solid import Solid, solid_of
from hairpipe.body.surface import Sites, site_points, site_uv
from hairpipe.body.tree import Tree
from hairpipe.body.vectors import row
from hairpipe.data import Groom
from hairpipe.errors import BadInput
from hairpipe.groom.binding import root_frames
from hairpipe.groom.chance import stream
from hairpipe.groom.curling import wind
from hairpipe.groom.laying import lay, lift_off
from hairpipe.groom.layout import GAP, SHORTEST, Layout, lay_out
from hairpipe.groom.ordering import order_along_curve
from hairpipe.groom.paint import Canvas, vertex_coat
from hairpipe.groom.resampling import put, stride_on
from hairpipe.groom.seeding import Density, seed_roots
from hairpipe.groom.style import Paint, Style

LONGEST_STEP = 0.0025  # along the axis of a strand, which is fine enough for ears and shoulders [m]
STEPS_A_TURN, STEPS_A_SEGMENT = 24, 3
OVERGROWTH = 1.25  # of the axis: the chords of curved hair are shorter than their arcs
LONGEST = 3.0  # [m]; hair of more is likelier a length in another unit
FEWEST_SEGMENTS_A_TURN = 4  # that still look like a curl


def grow(canvas: Canvas, style: Style, density: Paint | None, strands: int, segments: int) -> Groom:
    """Return hair grown on the scalp, every strand cut into equal segments that add up to its length.

    density   painted number of roots per area, relative to that of the scalp map alone
    strands   number of roots; hair that comes out shorter than a millimetre is left out
    segments  of every strand
    Raise BadInput where no hair can grow.
    """
    mesh = canvas.body.mesh
    sites = seed_roots(mesh, scalp_density(canvas, density), strands, stream(canvas.seed, "roots"))
    order = order_along_curve(site_points(mesh, sites))
    sites = Sites(*(array[order] for array in sites))
    frames = root_frames(mesh.points, mesh.triangles, *sites)
    layout = lay_out(canvas, style, sites, frames)
    ids = np.flatnonzero(layout.lengths >= SHORTEST)
    if len(ids) == 0:
        raise BadInput("all hair is shorter than a millimetre", where="length", right="paint some of it longer")
    sites, layout = Sites(*(array[ids] for array in sites)), Layout(*(array[ids] for array in layout))
    warn_of_zigzag(layout, segments)
    if layout.lengths.max() > LONGEST:
        warnings.warn(f"hair of up to {layout.lengths.max():.3g} m: is length in metres?", stacklevel=2)
    points = grow_strands(*solid_of(mesh), layout, style.bend, style.curl.onset if style.curl else np.inf, segments)
    offsets = np.arange(len(ids) + 1, dtype=np.int32) * np.int32(segments + 1)
    return Groom(points.reshape(-1, 3), offsets, ids.astype(np.int32), *sites, frames[ids], site_uv(mesh, sites))


def scalp_density(canvas: Canvas, paint: Paint | None) -> Density:
    """Return the density of roots: the map "scalp" of the body times what is painted."""
    scalp = vertex_coat(canvas.body, "scalp", "scalp")
    coat = None if paint is None else canvas.coat(paint, "density")
    return scalp if coat is None else lambda sites: scalp(sites) * coat(sites)


def warn_of_zigzag(layout: Layout, segments: int) -> None:
    """Warn where curls have too few segments a turn to be round."""
    turn = np.hypot(2.0 * np.pi * layout.radii, layout.pitches)
    needed = FEWEST_SEGMENTS_A_TURN * layout.lengths / turn
    coarse = (layout.radii > 0.0) & (needed > segments)
    if coarse.any():
        count, most = np.count_nonzero(coarse), int(np.ceil(needed[coarse].max()))
        warnings.warn(
            f"{count} curls have fewer than {FEWEST_SEGMENTS_A_TURN} segments a turn and come out angular: "
            f"with segments = {most} none would",
            stacklevel=2,
        )


@njit(cache=True)
def axis_step(length: float, segments: int, radius: float, pitch: float) -> float:
    """Return the step along the axis of a strand [m] that is fine enough for its segments and its curl."""
    step = min(LONGEST_STEP, length / (segments * STEPS_A_SEGMENT))
    return min(step, pitch / STEPS_A_TURN) if radius > 0.0 else step


@njit(cache=True, parallel=True)
def grow_strands(
    tree: Tree, normals: np.ndarray, layout: Layout, bend: float, onset: float, segments: int
) -> np.ndarray:
    """Return the points of strands of equal segments [m], (S, segments + 1, 3).

    tree, normals  of the body's Solid: a parallel loop takes no tuple within a tuple
    bend           length over which a strand turns to where it is pulled [m]
    onset          length over which the radius of its curl grows [m]
    """
    points = np.empty((len(layout.roots), segments + 1, 3))
    for s in prange(len(points)):
        length, radius, pitch = layout.lengths[s], layout.radii[s], layout.pitches[s]
        step = axis_step(length, segments, radius, pitch)
        axis = np.empty((int(np.ceil(OVERGROWTH * length / step)) + 1, 3))
        put(axis, 0, row(layout.roots, s))
        solid = Solid(tree, normals)
        lay(solid, axis, row(layout.ahead, s), row(layout.combs, s), layout.layers[s], bend, step)
        if radius > 0.0:
            wind(axis, step, radius, pitch, onset, layout.phases[s])
        lift_off(solid, axis, GAP)
        stride_on(axis, length / segments, points[s])
    return points
