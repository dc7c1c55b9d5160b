"""Motion of hair and its roots in numbers: speed, stretch, tension, swing, impulses of goals, and cost of a frame."""

from collections.abc import Mapping, Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import Collider
from hairpipe.measure.contact import depths, free_points, without_roots
from hairpipe.strands.layout import Layout, lay_out
from hairpipe.strands.registry import strand_models
from hairpipe.values import Ends, Groom, Mesh, PointValues, Strands, Table
from hairpipe.values.groom import check_driver, segment_lengths, strand_lengths
from hairpipe.values.hair import HairState
from hairpipe.values.random_streams import GOLDEN
from hairpipe.values.strand_arrays import members_of, points_of_strands
from hairpipe.values.table import table_of_columns, table_of_rows

COLUMNS = (
    *("time [s]", "rms speed [mm/s]", "fastest [mm/s]"),
    "longest stretch [%]",  # of a whole strand, over its length at the first frame
    "mean height [mm]",  # along Y
    *("moved [mm]", "moved farthest [mm]"),  # rms and largest displacement since the previous frame; 0 at a cut
)


def measure_speeds(hair: Mapping[int, Strands], fps: float, cuts: Sequence[int] = ()) -> Table:
    """Return a row for every frame, over all points but the roots, which are prescribed; time zero is the first."""
    frames = list(hair)
    first = previous = hair[frames[0]]
    lengths = strand_lengths(first.points, first.offsets)
    rows = []
    for frame in frames:
        now = hair[frame]
        previous = now if frame in cuts else previous
        moved = np.linalg.norm(free_points(now) - free_points(previous), axis=1)
        displacements = 1e3 * np.sqrt(np.mean(moved**2)), 1e3 * moved.max()
        rows.append(((frame - frames[0]) / fps, *row_of(now, lengths), *displacements))
        previous = now
    return table_of_rows(COLUMNS, rows)


def watch(hair: Strands, groom: Groom) -> Table:
    """Return the row of `measure_speeds` of one frame, with the stretch against the groom."""
    return table_of_rows(COLUMNS[1:-2], [row_of(hair, strand_lengths(groom.points, groom.offsets))])


def row_of(hair: Strands, lengths: np.ndarray) -> tuple[float, ...]:
    """Return speeds, stretch over lengths [m], (S,), and height of hair."""
    speeds = np.linalg.norm(without_roots(hair.velocities, hair), axis=1)
    return (
        1e3 * np.sqrt(np.mean(speeds**2)),
        1e3 * speeds.max(),
        100.0 * (strand_lengths(hair.points, hair.offsets) / lengths - 1.0).max(),
        1e3 * free_points(hair)[:, 1].mean(),
    )


def layout_of(groom: Groom, state: HairState) -> Layout:
    """Return the layout of a state, of the model with as many particles; BadInput where there is none."""
    dtype = state.velocities.dtype
    layouts = [lay_out(groom.offsets, kind.shape, dtype) for kind in strand_models().values()]
    found = next((layout for layout in layouts if layout.first[-1] == len(state.positions)), None)
    if found is None:
        raise BadInput("hair and groom are not the same strands", right="in.groom: the groom that is simulated")
    return found


def tensions(layout: Layout, state: HairState) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Return every strand with its points [m], (n+1, 3), and the tension of its segments [N], (n,).

    The force across a section of a segment is sum T d, over the linear springs that it cuts; the tension is its
    component along the segment. Altitude springs are excluded: they separate tetrahedra and have no force along a
    hanging or pulled strand.
    """
    shape = layout.shape
    found = []
    for block, segments in enumerate(layout.segments):
        rows = slice(layout.first[block], layout.first[block + 1])
        x, T = state.positions[rows], state.tensions[rows]
        total = np.zeros_like(x)
        for offset in range(1, (min(T.shape[1], shape.reach) if shape.unknowns == 3 else 1) + 1):
            span = x[offset:] - x[:-offset]
            pull = T[:-offset, None, offset - 1] * span / np.linalg.norm(span, axis=1, keepdims=True)
            for cut in range(offset):
                total[cut : cut + len(pull)] += pull
        axis = x[shape.axis]
        edges = np.diff(axis, axis=0)
        cuts = total[shape.axis][:segments]
        along = np.sum(cuts * edges, axis=1) / np.linalg.norm(edges, axis=1)
        lanes = np.flatnonzero(~layout.idle[block])
        found += [(int(layout.strands[block, lane]), axis[:, :, lane], along[:, lane]) for lane in lanes]
    return found


def measure_root_motion(
    groom: Groom, drivers: Mapping[int, Mesh | Ends], fps: float, cuts: Sequence[int] = ()
) -> Table:
    """Return a row for every frame: root mean square, over the strands, of speed and acceleration of the roots.

    drivers  bodies or ends at the frames of the run, ascending; frames may be missing
    cuts     frames at which the shot is cut: differences are one-sided there
    """
    frames = list(drivers)
    places = np.array([root_places(groom, drivers[frame]) for frame in frames])
    takes = np.split(np.arange(len(frames)), np.searchsorted(frames, cuts))
    found = [differences(places[take], np.array(frames)[take]) for take in takes if len(take)]
    rates, accelerations = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return table_of_columns(
        {"frame": frames, "speed [m/s]": rms(rates * fps), "acceleration [m/s^2]": rms(accelerations * fps**2)}
    )


def differences(values: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both derivatives of values (n, ...) at ascending places (n,): of a parabola through three neighbours.

    Beyond both ends values are extrapolated linearly, a single one as a constant.
    """
    first, second = np.zeros_like(values), np.zeros_like(values)
    if len(at) > 1:
        first = np.gradient(values, at, axis=0)
        slopes = np.diff(values, axis=0).T / np.diff(at)
        second[1:-1] = (2.0 * np.diff(slopes) / (at[2:] - at[:-2])).T
    return first, second


def root_places(groom: Groom, driver: Mesh | Ends) -> np.ndarray:
    """Return the positions of the roots [m], (S, 3); BadInput for the ends of another groom."""
    check_driver(driver, groom)
    if isinstance(driver, Ends):
        rest = groom.points[groom.offsets[:-1]]
        return np.einsum("sij,sj->si", driver.roots[:, :, :3], rest) + driver.roots[:, :, 3]
    corners = driver.points[driver.triangles[groom.root_triangles]]
    return np.einsum("sk,skc->sc", groom.root_barycentrics, corners)


def rms(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=1))


LAG_COLUMNS = (
    *("lag [frames]", "correlation [1]"),  # delay of the largest correlation of the swing with that of the roots
    *("swing [degrees]", "swing of the roots [degrees]"),  # peak to peak, of the lower quarters, in least squares
)
"""Rotations are those since the first frame, about the vertical through the middle of the roots."""
LOWER = 0.75  # share of the points of a strand after which the lower quarter begins
FINE = 10  # number of tried lags per frame
LONGEST = 0.25  # longest lag, over the duration of the shot


def swing_table(hair: Mapping[int, Strands]) -> Table:
    """Return one row; BadInput where roots do not turn."""
    low, roots = [], []
    for frame in hair:
        ends = hair[frame].offsets
        points = hair[frame].points.astype(float)[:, [2, 0]]
        starts = (ends[:-1] + np.ceil(LOWER * np.diff(ends))).astype(int)
        middle = points[ends[:-1]].mean(axis=0)
        cuts = np.stack([starts, ends[1:]], axis=1).ravel()
        sums = np.add.reduceat(np.append(points, [[0.0, 0.0]], axis=0), cuts)[::2]
        low.append(sums / (ends[1:] - starts)[:, None] - middle)
        roots.append(points[ends[:-1]] - middle)
    swung, driven = _turns(low), _turns(roots)
    if not np.ptp(driven) > 0.0:
        raise BadInput("the roots of the hair do not turn", where="in.hair", right="hair on a head that shakes")
    lags = np.arange(int(LONGEST * FINE * len(driven)) + 1) / FINE
    fits = [_correlation(driven, swung, lag) for lag in lags]
    best = int(np.argmax(fits))
    return table_of_rows(LAG_COLUMNS, [(lags[best], fits[best], np.ptp(swung), np.ptp(driven))])


def _turns(places: list[np.ndarray]) -> np.ndarray:
    """Return the rotation of places, (n, 2) each, since the first frame [degrees], (frames,)."""
    first = places[0]
    sines = [np.sum(first[:, 0] * now[:, 1] - first[:, 1] * now[:, 0]) for now in places]
    cosines = [np.sum(first * now) for now in places]
    return np.degrees(np.unwrap(np.arctan2(sines, cosines)))


def _correlation(first: np.ndarray, second: np.ndarray, lag: float) -> float:
    """Return the correlation of a series with another one, delayed by so many samples."""
    at = np.arange(len(first) - int(np.ceil(lag)))
    return float(np.corrcoef(first[at], np.interp(at + lag, np.arange(len(second)), second))[0, 1])


def measure_points(
    hair: Strands, groom: Groom | None, state: HairState | None, bodies: Sequence[Collider]
) -> PointValues:
    """Return `depth [mm]` where there are bodies, `stretch [%]` with a groom, and `tension [uN]` with a state as well.

    For hair in locks also `lock`, a colour of each, and `follows`, 0 for simulated hair and 1 for followers, whose
    tension is that of the guide, which has as many segments.

    A point has the stretch and the tension of the segment that ends there, a root those of the first segment. Raises
    BadInput if groom or state do not match the strands.
    """
    inner = np.ones(len(hair.points), bool)
    inner[hair.offsets[:-1]] = False
    found: dict[str, np.ndarray] = {}
    if bodies:
        found["depth [mm]"] = spread(1e3 * depths(hair, bodies), inner, 0.0)
    if groom is not None:
        if not np.array_equal(groom.offsets, hair.offsets):
            raise BadInput("hair and groom are not the same strands", right="in.groom: the groom that is simulated")
        rest = segment_lengths(groom.points, groom.offsets)
        found["stretch [%]"] = spread(100.0 * (segment_lengths(hair.points, hair.offsets) / rest - 1.0), inner)
        if state is not None:
            pulls = sorted(tensions(layout_of(groom, state), state), key=lambda strand: strand[0])
            found["tension [uN]"] = spread(1e6 * np.concatenate([pull for _, _, pull in pulls]), inner)
            if state.locks is not None:
                counts = np.diff(hair.offsets)
                leaders = state.leaders(len(counts))
                found["tension [uN]"] = found["tension [uN]"][points_of_strands(leaders, hair.offsets)]
                found["lock"] = np.repeat(GOLDEN * leaders % 1.0, counts)
                found["follows"] = np.repeat(~state.simulated(len(counts)), counts).astype(float)
    if not found:
        raise BadInput("no input to measure with", right="in.surfaces, in.parts, or in.groom, with in.state or without")
    return PointValues(tuple(found), np.stack(list(found.values())).astype(np.float32), hair.offsets)


def spread(values: np.ndarray, inner: np.ndarray, root: float | None = None) -> np.ndarray:
    """Return values of all points except roots as those of all points; roots have a value of their own, or the next."""
    spread_out = np.zeros(len(inner))
    spread_out[inner] = values
    roots = np.flatnonzero(~inner)
    spread_out[roots] = spread_out[roots + 1] if root is None else root
    return spread_out


IMPULSE_COLUMNS = (
    *("time [s]", "impulse x [N s]", "impulse y [N s]", "impulse z [N s]"),
    "mean force [N]",  # magnitude of the impulse over the duration of a frame
    "largest force on a strand [N]",  # the same of the strand with the largest impulse
)


def measure_impulses(groom: Groom, states: Mapping[int, HairState], group: str | None, fps: float) -> Table:
    """Return a row a frame: the impulse of goals in the solves of its steps, before contact; zero without goals.

    Raises BadInput for a group that the groom does not have.
    """
    some = slice(None) if group is None else members_of(groom, (group,), "group")
    rows = []
    for n, state in enumerate(states.values()):
        impulses = np.zeros((len(groom.ids), 3)) if state.impulses is None else state.impulses
        total = impulses[some].sum(axis=0)
        largest = np.linalg.norm(impulses[some], axis=1).max()
        rows.append((n / fps, *total.tolist(), fps * float(np.linalg.norm(total)), fps * float(largest)))
    return table_of_rows(IMPULSE_COLUMNS, rows)


COST_COLUMNS = ("seconds per frame", "fastest frame [s]", "slowest frame [s]", "frames timed")


def cost_table(nodes: Sequence[Mapping[int, float]], warm: int, timed: int) -> Table:
    """Return one row: the time of a frame of all nodes together [s], of their seconds by frame; NaN without frames.

    The first frame and so many `warm` ones after it are excluded: kernels are compiled, hair falls into its first
    contacts. In a shot without any after those, the last frame is used. Frames missing for a node are excluded.
    """
    frames = sorted(set.intersection(*(set(node) for node in nodes)))[1:]  # those that all nodes have, but the first
    seconds = [sum(node[frame] for node in nodes) for frame in frames]
    counted = seconds[min(warm, max(len(seconds) - 1, 0)) :][:timed] or [np.nan]
    row = (float(np.median(counted)), min(counted), max(counted), min(len(counted), len(seconds)))
    return table_of_rows(COST_COLUMNS, [row])
