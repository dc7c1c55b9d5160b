"""Hair grown from the scalp of a body: its style strand by strand, its axis, and the curl wound around it.

The axis of a strand leaves the skin, bends over, slides along the body and hangs. The body is closed first, so that
every point is inside or outside.
"""

import warnings
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import root_frames
from hairpipe.geometry.solid import Solid, distance_and_normal, solid_of
from hairpipe.geometry.triangle_tree import Tree
from hairpipe.geometry.vec3 import Vector, cross, dot, flattened, length, minus, mix, plus, put, row, scaled, unit
from hairpipe.groom.importing import warn_of_fewer
from hairpipe.groom.resampling import Cut, fitting, stride_on
from hairpipe.groom.seeding import Density, seed_roots
from hairpipe.groom.settings import Style
from hairpipe.levelset.closed_surface import capped, edge_uses, holes
from hairpipe.values import Groom, Mesh
from hairpipe.values.painting import Canvas, Paint, maps_at, vertex_coat
from hairpipe.values.random_streams import stream
from hairpipe.values.strand_arrays import offsets_of
from hairpipe.values.triangles import Sites, area_vectors, normalized, site_uv

LEAST_BODY = 1e-3  # volume over area^(3/2) of a body: a ball has 0.094, a sheet closed by its own back 0


def closed(mesh: Mesh) -> Mesh:
    """Return a mesh without holes, their caps facing outward; a sheet, which has no inside, is returned unchanged."""
    edges, uses = edge_uses(mesh.triangles)
    found = holes(edges[uses % 2 == 1], mesh.points)
    if not found:
        return mesh
    following = np.roll(mesh.triangles, -1, axis=1)
    for n, hole in enumerate(found):  # A cap faces outward if the loop runs like the triangles around it.
        first, second = hole.loop[:2]
        if not ((mesh.triangles == first) & (following == second)).any():
            found[n] = hole._replace(loop=hole.loop[::-1], weights=hole.weights[::-1])
    whole = capped(mesh, found)
    areas = area_vectors(whole)
    middle = whole.points.mean(axis=0)
    volume = np.sum((whole.points[whole.triangles[:, 0]] - middle) * areas) / 3.0
    return whole if volume > LEAST_BODY * np.linalg.norm(areas, axis=1).sum() ** 1.5 else mesh


@njit(cache=True)
def wind(axis: np.ndarray, step: float, radius: float, pitch: float, onset: float, phase: float) -> None:
    """Wind a polyline (k, 3) with a point every step [m] into a helix around itself, in place.

    x(s) = a(s) + R(s) (cos(phi) n + sin(phi) b), phi = 2 pi s / pitch + phase, R(s) growing smoothly over onset [m]
    from 0 to radius [m]; n and b are transported along the axis without twist.
    """
    last = len(axis) - 1
    normal = (0.0, 0.0, 0.0)
    before = row(axis, 0)
    for k in range(last + 1):
        here = row(axis, k)
        ahead = row(axis, k + 1) if k < last else plus(here, minus(here, before))
        tangent = unit(minus(ahead, before), (0.0, -1.0, 0.0))
        before = here  # The old place of the point before, which has been moved: tangents are those of the axis.
        across = (1.0, 0.0, 0.0) if abs(tangent[0]) < 0.7 else (0.0, 1.0, 0.0)
        normal = unit(flattened(normal, tangent), unit(flattened(across, tangent), across))
        t = min(k * step / onset, 1.0)
        angle = 2.0 * np.pi * k * step / pitch + phase
        reach = radius * t * t * (3.0 - 2.0 * t)
        around = plus(scaled(np.cos(angle), normal), scaled(np.sin(angle), cross(tangent, normal)))
        put(axis, k, plus(here, scaled(reach, around)))


GAP = 0.001  # between the skin and any hair beyond its root [m]
FLATTEST = 0.001  # pitch of a curl that is not taken for nothing [m]
BACK_OF_HEAD = 0.6  # how far the skin faces backwards where nothing is left of the parting


class Layout(NamedTuple):
    roots: np.ndarray  # [m], (S, 3)
    ahead: np.ndarray  # unit direction of the hair at the skin, (S, 3)
    combs: np.ndarray  # pull where it touches the body, in units of gravity, (S, 3)
    layers: np.ndarray  # distance from the body at which it slides [m], (S,)
    lengths: np.ndarray  # [m], (S,)
    radii: np.ndarray  # of the curls [m], (S,); 0 for straight hair
    pitches: np.ndarray  # of the curls [m], (S,)
    phases: np.ndarray  # of the curls at the root [rad], (S,)


def lay_out(canvas: Canvas, style: Style, sites: Sites, frames: np.ndarray) -> Layout:
    roots, normals = frames[:, :, 3], frames[:, :, 2]
    comb = style.comb
    combs = comb.stray * stream(canvas.seed, "stray").normal(size=roots.shape)
    side = np.where(roots[:, 0] < comb.parting, -1.0, 1.0)
    parted = np.clip(1.0 + normals[:, 2] / BACK_OF_HEAD, 0.0, 1.0)
    combs[:, 0] += side * parted * canvas.numbers(comb.sideways, "comb.sideways", sites)
    combs[:, 2] -= canvas.numbers(comb.back, "comb.back", sites)
    pulls = combs + np.array((0.0, -1.0, 0.0))
    along = normalized(pulls - np.sum(pulls * normals, axis=1, keepdims=True) * normals)
    lift = np.radians(canvas.numbers(style.lift, "lift", sites))
    radii = np.zeros(len(roots))
    pitches = np.ones(len(roots))
    if style.curl is not None:
        radii = canvas.numbers(style.curl.radius, "curl.radius", sites)
        pitches = canvas.numbers(style.curl.pitch, "curl.pitch", sites)
        radii = np.where(pitches < FLATTEST, 0.0, radii)
        pitches = np.maximum(pitches, FLATTEST)
    depth = stream(canvas.seed, "layer").random(len(roots))
    turn = stream(canvas.seed, "phase").random(len(roots))
    return Layout(
        roots=roots,
        ahead=normalized(np.cos(lift)[:, None] * along + np.sin(lift)[:, None] * normals),
        combs=combs,
        layers=GAP + depth * style.volume + radii,
        lengths=canvas.numbers(style.length, "length", sites),
        radii=radii,
        pitches=pitches,
        phases=2.0 * np.pi * turn,
    )


DOWN = (0.0, -1.0, 0.0)
FADE = 0.01  # above the layer it lies in, over which a strand leaves the comb to gravity [m]
LEAST = 0.5  # of the gap, that is enough where segments cut corners
PUSHES, WAYS = 8, 200  # attempts to turn a segment out of the body, and directions tried where all fail
GOLDEN = np.pi * (3.0 - np.sqrt(5.0))  # angle that spreads directions evenly over the sphere [rad]
TOUCHED = 1e-7  # that may lack of the gap [m]
RISE = 0.03  # from the root, over which a strand rises to its layer, and clears the skin by the full gap [m]


@njit(cache=True)
def pull(comb: Vector, touch: float, normal: Vector) -> Vector:
    """Return the direction a strand is pulled: gravity, and where it touches the body the comb; never into the body."""
    direction = unit(plus(DOWN, scaled(touch, flattened(comb, normal))), DOWN)
    return minus(direction, scaled(touch * min(dot(direction, normal), 0.0), normal))


@njit(cache=True)
def lay(solid: Solid, axis: np.ndarray, ahead: Vector, comb: Vector, layer: float, bend: float, step: float) -> None:
    """Write a polyline (k, 3), a point every step [m], from its first point, the root, where it goes `ahead`.

    comb, layer  pull on the body, in units of gravity, and distance from it at which the strand slides [m]
    bend         length over which it bends to the direction of its pull [m]
    """
    here = row(axis, 0)
    gap, normal, place = distance_and_normal(solid, here, 0)
    need, free = 0.0, 0.0
    for k in range(1, len(axis)):
        touch = min(max(1.0 - (gap - need) / FADE, 0.0), 1.0)  # The comb acts on hair that lies on the body only.
        ahead = unit(mix(ahead, pull(comb, touch, normal), min(step / bend, 1.0)), ahead)
        there = plus(here, scaled(step, ahead))
        need = layer * (1.0 - np.exp(-k * step / RISE))
        free -= step
        if free <= 0.0:  # The distance bounds how far the strand goes before it can meet the body: no look until then.
            gap, normal, place = distance_and_normal(solid, there, place)
            free = gap - layer - FADE
        if gap < need:
            ahead = unit(minus(plus(there, scaled(need - gap, normal)), here), ahead)
            there = plus(here, scaled(step, ahead))
            gap = need
        put(axis, k, there)
        here = there


@njit(cache=True)
def lift_off(solid: Solid, curve: np.ndarray, gap: float) -> None:
    """Move the points of a polyline (k, 3) out of the body, in place, to clear it by a gap that grows to gap [m]."""
    free, way, place = 0.0, 0.0, 0
    before = row(curve, 0)
    for k in range(1, len(curve)):
        here = row(curve, k)
        step = length(minus(here, before))
        free = free - step
        way = way + step
        before = here
        if free <= 0.0:
            d, normal, place = distance_and_normal(solid, here, place)
            free = d - gap
            need = gap * min(way / RISE, 1.0)
            if d < need:
                put(curve, k, plus(here, scaled(need - d, normal)))


@njit(cache=True)
def clearance(solid: Solid, here: Vector, there: Vector, need: float, place: int) -> tuple[float, float, Vector, int]:
    """Return the distance of a segment's end from the body [m], its lack [m], outward direction and closest triangle.

    need   required distance of the end [m], while the middle should be outside; place  guess of the closest triangle
    """
    gap, normal, place = distance_and_normal(solid, there, place)
    lack = need - gap
    if gap < length(minus(there, here)):
        inside, across, _ = distance_and_normal(solid, mix(here, there, 0.5), place)
        if -2.0 * inside > lack:
            lack = -2.0 * inside
            normal = across
    return gap, lack, normal, place


@njit(cache=True)
def turned_out(solid: Solid, here: Vector, there: Vector, need: float, place: int) -> Vector:
    """Return the end of a segment rotated about its root, which is outside, until it is clear of the body.

    The deficit is added and the length restored, iteratively. If that fails, as between two walls, it takes the
    direction nearest to its own among many with enough clearance; otherwise that with the largest clearance.
    """
    way = length(minus(there, here))
    end = there
    for _ in range(PUSHES):
        _, lack, normal, place = clearance(solid, here, end, need, place)
        if lack <= TOUCHED:
            return end
        end = plus(here, scaled(way, unit(minus(plus(end, scaled(lack, normal)), here), normal)))
    best = end
    least = np.inf
    nearest = -np.inf
    for i in range(WAYS):  # A spiral over the sphere: directions are spread evenly, and the same for every strand.
        height = 1.0 - (2.0 * i + 1.0) / WAYS
        turn = i * GOLDEN
        across = np.sqrt(1.0 - height * height)
        aside = (across * np.cos(turn), height, across * np.sin(turn))
        end = plus(here, scaled(way, aside))
        _, lack, _, _ = clearance(solid, here, end, LEAST * need, place)
        along = dot(aside, minus(there, here)) if lack <= 0.0 else -np.inf
        if along > nearest or (nearest == -np.inf and lack < least):
            best, least, nearest = end, lack, along
    return best


@njit(cache=True)
def keep_out(solid: Solid, points: np.ndarray, gap: float) -> None:
    """Rotate segments of a strand, (k, 3), out of the body, in place, from the root on; lengths and curls are kept.

    Only points with less than LEAST of the gap [m], which is full from RISE on, are moved.
    """
    free, way, place = 0.0, 0.0, 0
    for k in range(1, len(points)):
        here = row(points, k - 1)
        there = row(points, k)
        step = length(minus(there, here))
        free = free - step
        way = way + step
        if free > 0.0:
            continue
        need = gap * min(way / RISE, 1.0)
        d, lack, _, place = clearance(solid, here, there, LEAST * need, place)
        if lack > 0.0:
            clear = turned_out(solid, here, there, need, place)
            shift = minus(clear, there)
            for j in range(k, len(points)):  # The rest goes along, so that its shape stays.
                put(points, j, plus(row(points, j), shift))
            d, _, place = distance_and_normal(solid, clear, place)
        free = d - gap


LONGEST_STEP = 0.0025  # along the axis of a strand, which is fine enough for ears and shoulders [m]
STEPS_A_TURN, STEPS_A_SEGMENT = 24, 3
OVERGROWTH = 1.25  # of the axis: the chords of curved hair are shorter than their arcs
LONGEST = 3.0  # [m]; hair of more is likelier a length in another unit
FEWEST_SEGMENTS_A_TURN = 4  # that still look like a curl


def grow(canvas: Canvas, style: Style, density: Paint | None, strands: int, cut: Cut) -> Groom:
    """Return hair grown on the scalp, every strand cut into equal segments that add up to its length.

    density   painted number of roots per area, relative to that of the scalp map alone
    strands   number of roots; hair shorter than the shortest segment is omitted

    Raises BadInput if no hair can grow.
    """
    mesh = canvas.body.mesh
    scalp = vertex_coat(canvas.body, "scalp", "scalp")
    coat = None if density is None else canvas.coat(density, "density")
    wanted: Density = scalp if coat is None else lambda sites: scalp(sites) * coat(sites)
    sites = seed_roots(mesh, wanted, strands, stream(canvas.seed, "roots"))
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
    turns = np.where(layout.radii > 0.0, np.hypot(2.0 * np.pi * layout.radii, layout.pitches), np.inf)
    wanted_segments = cut.wanted(layout.lengths, fitting(layout.lengths, turns))
    most = cut.bearable(layout.lengths)
    if cut != Cut(shortest=cut.shortest):
        warn_of_fewer(ids[most < wanted_segments], cut.shortest)
    counts = np.minimum(wanted_segments, most)
    needed = FEWEST_SEGMENTS_A_TURN * (layout.lengths / turns)
    coarse = needed > counts
    if coarse.any():
        warnings.warn(
            f"{np.count_nonzero(coarse)} curls have fewer than {FEWEST_SEGMENTS_A_TURN} segments per turn and are "
            f"angular; segments = {int(np.ceil(needed[coarse].max()))} avoids this",
            stacklevel=2,
        )
    offsets = offsets_of(counts + 1)
    onset = style.curl.onset if style.curl else np.inf
    points = grow_strands(*solid_of(closed(mesh)), layout, style.bend, onset, offsets)
    maps = maps_at(canvas.body, sites)
    return Groom(points, offsets, ids, *sites, frames[ids], site_uv(mesh, sites), maps=maps)


@njit(cache=True, parallel=True)
def grow_strands(
    tree: Tree, normals: np.ndarray, layout: Layout, bend: float, onset: float, offsets: np.ndarray
) -> np.ndarray:
    """Return the points of strands of equal segments [m], (P, 3), by the offsets of strands.

    tree, normals  those of the body's Solid: a parallel loop does not accept a tuple within a tuple
    bend, onset    length over which a strand bends to its pull, and over which the radius of its curl grows [m]
    """
    points = np.empty((offsets[-1], 3))
    for s in prange(len(layout.roots)):  # Strands are independent: each thread writes points of its own.
        extent, radius, pitch = layout.lengths[s], layout.radii[s], layout.pitches[s]
        segments = offsets[s + 1] - offsets[s] - 1
        step = min(LONGEST_STEP, extent / (segments * STEPS_A_SEGMENT))
        step = min(step, pitch / STEPS_A_TURN) if radius > 0.0 else step
        axis = np.empty((int(np.ceil(OVERGROWTH * extent / step)) + 1, 3))
        put(axis, 0, row(layout.roots, s))
        solid = Solid(tree, normals)
        lay(solid, axis, row(layout.ahead, s), row(layout.combs, s), layout.layers[s], bend, step)
        if radius > 0.0:
            wind(axis, step, radius, pitch, onset, layout.phases[s])
        lift_off(solid, axis, GAP)
        strand = points[offsets[s] : offsets[s + 1]]
        stride_on(axis, extent / segments, strand)
        keep_out(solid, strand, GAP)
    return points


@njit(cache=True, parallel=True)
def keep_strands_out(tree: Tree, normals: np.ndarray, points: np.ndarray, offsets: np.ndarray, gap: float) -> None:
    """Rotate segments of strands out of a body, in place, see `keep_out`; points (P, 3) [m], by the offsets."""
    for s in prange(len(offsets) - 1):
        keep_out(Solid(tree, normals), points[offsets[s] : offsets[s + 1]], gap)


@njit(cache=True, parallel=True)
def depths(tree: Tree, normals: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the signed distances of points, (P, 3), from a body, negative inside [m], (P,)."""
    found = np.empty(len(points))
    for i in prange(len(points)):
        found[i] = distance_and_normal(Solid(tree, normals), row(points, i), 0)[0]
    return found
