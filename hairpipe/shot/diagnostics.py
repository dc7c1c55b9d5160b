"""Warnings of a simulation: deep roots, stretched segments, lost and held strands."""

from collections.abc import Sequence
from warnings import warn

import numpy as np

from hairpipe.contact.body_projection import STRETCH
from hairpipe.geometry.triangles import area_vectors
from hairpipe.groom.binding import name_strands
from hairpipe.levelset.collider import Collider, SdfSample
from hairpipe.shot.settings import Scene
from hairpipe.solve.boundary import Driver
from hairpipe.solve.stage import State
from hairpipe.strands.hair_model import HairModel
from hairpipe.strands.interface import may_be_lost
from hairpipe.values import Groom, Mesh
from hairpipe.values.groom import segment_lengths
from hairpipe.values.hair import HairState

SHALLOW = 2e-3
"""A root that lies so little below the skin is an ordinary one [m], whatever its segments are."""
FEW = 0.01
"""Share of the strands that may repeat steps in a frame without a warning."""
MORE = 1.1
"""Smallest ratio of a new stretch to the reported one."""
GROWN = 1.1
"""Smallest ratio of the size of skin that is reported, of later to earlier skin or the opposite."""
GROWN_MORE = 1.2
"""The same of a size to the one that was reported last."""
_FREE = 0.1  # taken as the limit where a scene has none
_EXACT = 0.005


def warn_of_sweep(scene: Scene) -> None:
    """Warn where the published solver of contact is chosen, which gives energy to hairs that touch."""
    if scene.collisions is not None and scene.collisions.solver == "sweep":
        message = 'collisions.solver = "sweep" adds energy to strands that rest on each other without friction'
        warn(f'{message}, so that they do not come to rest (solver = "coupled" avoids this)', stacklevel=3)


def warn_of_weight(hair: HairModel, scene: Scene) -> None:
    """Warn of strands whose weight stretches them beyond the strain limit, which alone holds them: they fall on."""
    if scene.strain is None:
        return
    first = hair.model.first
    beyond = np.cumsum(hair.model.mass[::-1].astype(float), axis=0)[::-1]  # of all strands up to the last
    masses = beyond - np.repeat(np.append(beyond, np.zeros_like(beyond[:1]), axis=0)[first[1:]], np.diff(first), axis=0)
    strains = np.maximum.reduceat(scene.gravity * masses / hair.model.constants[:, 0], first[:-1])
    soft = (strains > scene.strain.tolerance) & ~hair.layout.idle
    if soft.any():
        names = name_strands(hair.groom.ids[np.sort(hair.layout.strands[soft])])
        stretched = f"the weight of {np.count_nonzero(soft)} strands stretches them by up to {strains[soft].max():.2g}"
        warn(
            f"{stretched}, above strain.tolerance = {scene.strain.tolerance:g}, and they do not come to rest: {names} "
            "(a larger tolerance, or a smaller material.softening)",
            stacklevel=3,
        )


def warn_of_deep_roots(hair: HairModel, positions: np.ndarray, bodies: Sequence[Collider]) -> None:
    """Warn of the strands whose roots are so deep inside bodies at present that their first segments end inside.

    positions  of the particles [m], (rows, 3, W)
    """
    offsets = hair.layout.offsets
    points = hair.layout.axis(positions).astype(float)[offsets[:-1]]
    probe = SdfSample.blank(len(points), 0.0)
    for body in bodies:
        body.probe(points, 0.0, probe)
    first = hair.groom.points[offsets[:-1] + 1] - hair.groom.points[offsets[:-1]]
    deep = -probe.distance > np.maximum(np.linalg.norm(first, axis=1), SHALLOW)
    if deep.any():
        order = np.argsort(probe.distance, kind="stable")[: np.count_nonzero(deep)]
        ids = hair.groom.ids[order[deep[order]]]
        message = f"{np.count_nonzero(deep)} of {len(deep)} roots are inside the body by more than a segment"
        worst = f"the deepest by {-1e3 * probe.distance.min():.3g} mm: {name_strands(ids)}"
        mend = "roots on the skin: check unit, position and pose of groom and body"
        warn(f"{message}, {worst} ({mend})", stacklevel=3)


def warn_of_stretch(hair: HairModel, positions: np.ndarray, scene: Scene, frame: int, reported: float) -> float:
    """Warn of the strand with the largest stretch, if it exceeds the stretch that a body may cause.

    positions  of the particles [m], (rows, 3, W)
    reported   last stretch that was reported; only a stretch that exceeds it by a margin is reported again

    Returns the last stretch that was reported.
    """
    offsets = hair.layout.offsets
    rest = segment_lengths(hair.groom.points, hair.layout.offsets)
    stretch = segment_lengths(hair.layout.axis(positions), offsets) / rest
    worst = int(np.argmax(stretch))
    limit = _FREE if scene.strain is None else scene.strain.tolerance
    if not stretch[worst] > max((1.0 + limit) * (1.0 + STRETCH) + _EXACT, MORE * reported):
        return reported
    strand = int(np.searchsorted(offsets[1:] - np.arange(1, len(offsets)), worst, side="right"))
    far = f"a segment of strand {hair.groom.ids[strand]} is stretched to {stretch[worst]:.3g} times its length"
    warn(
        f"{far} at frame {frame}, above the limit of {1.0 + limit:.3g}: the constraints exceed the strain limit",
        stacklevel=3,
    )
    return float(stretch[worst])


def warn_of_growth(
    groom: Groom, drivers: tuple[Driver, Driver], frame: int, grown: float, reported: float
) -> tuple[float, float]:
    """Warn of skin that has grown, or shrunk, at the roots since the first frame: hair keeps its length.

    drivers   bodies at the previous frame and at this one; ends are of constant size
    grown     size of the skin at the previous frame over that at the first, the median over strands
    reported  the last ratio that was reported; only a ratio that differs from it by a margin is reported again

    Returns the ratio at this frame, and the last one that was reported.
    """
    here = [Mesh(b.points, b.triangles[groom.root_triangles]) for b in drivers if isinstance(b, Mesh)]
    if len(here) < 2:
        return grown, reported
    first, second = (np.linalg.norm(area_vectors(skin), axis=1) for skin in here)
    has_area = (first > 0.0) & (second > 0.0)
    if has_area.any():
        grown *= float(np.sqrt(np.median(second[has_area] / first[has_area])))
    change = abs(np.log(grown / reported))
    if not change > np.log(GROWN if reported == 1.0 else GROWN_MORE):
        return grown, reported
    done = "grown" if grown > 1.0 else "shrunk"
    message = f"the skin at the roots has {done} by {100.0 * abs(grown - 1.0):.0f} % since the first frame"
    warn(f"{message}, at frame {frame}, and hair keeps its length (a body of constant size)", stacklevel=3)
    return grown, grown


def warn_of_lost(hair: HairModel, before: HairState, after: HairState, frame: int) -> None:
    """Name the strands that repeated a step in a frame, unless they are few of many; see `solve/lost.py`."""
    if not may_be_lost(hair.model):
        return
    rows = hair.model.first[:-1]
    used = ~hair.layout.idle
    repeats = after.tensions[rows, 1]
    again = (repeats > before.tensions[rows, 1]) & used
    count = np.count_nonzero(again)
    if count > FEW * np.count_nonzero(used):
        names = name_strands(hair.groom.ids[np.unique(hair.layout.strands[again])])
        message = f"{count} strands were re-solved with backward Euler at frame {frame}: {names}"
        steps = int(repeats[used].sum())
        warn(f"{message} ({steps} such steps of all strands so far; a shorter steps.longest avoids them)", stacklevel=3)


def warn_of_held(hair: HairModel, now: State, mended: np.ndarray, steps: int, frame: int) -> None:
    """Warn of the strands that could not be solved in some steps of a frame, see `solve/lost.py`.

    now     hair at the end of the frame, with the number of steps
    mended  strands that were not finite at the start of the frame, (blocks, W) bool

    Raises ArithmeticError if no step could be solved for any strand, or if strands are held in single precision while
    double is available.
    """
    held = now.held
    used = ~hair.layout.idle
    if (mended & used).any():
        names = name_strands(hair.groom.ids[np.sort(hair.layout.strands[mended & used])])
        message = f"{np.count_nonzero(mended & used)} strands were not finite before frame {frame}"
        warn(f"{message} and restart from the groom: {names}", stacklevel=3)
    if not held.any():
        return
    count = np.count_nonzero(held[used])
    total = np.count_nonzero(used)
    names = name_strands(hair.groom.ids[np.sort(hair.layout.strands[used & (held > 0)])])
    message = f"{count} of {total} strands had no solution in {held.max()} of {steps} steps of frame {frame}: {names}"
    if now.failed >= steps:
        raise ArithmeticError(f"diverged: {message}")
    if hair.in_double is not None:
        raise ArithmeticError(f"{message} (in single precision)")
    warn(f"{message} (they moved rigidly with their roots)", stacklevel=3)
