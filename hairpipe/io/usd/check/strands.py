"""Rules for the strands of hair: they have a length, keep it, and are those of the groom at rest."""

from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom

from hairpipe.io.usd.check.finding import Fault, Rule
from hairpipe.io.usd.check.scene import Scene, Track
from hairpipe.io.usd.check.snapshot import Snapshot

COLLAPSED = 0.01  # of the median length
COINCIDENT = 1e-3  # of a strand's mean segment
REST = (2 / 3, 3 / 2)  # lengths of all strands over those at rest
OTHER = (0.5, 2.0)  # of one strand over its rest, beyond which that is another strand's
STRETCH = (0.8, 1.25)  # lengths of all strands over time
TORN = (0.2, 2.0)  # of one segment over time
SPIKE = 8.0  # times the other segments of a strand
SOME = 0.01  # share of strands that a rule minds
EVEN = 0.2  # by which segments of a strand may differ and count as even


def collapsed(scene: Scene) -> Iterator[Fault]:
    """Find strands without length, and points of a strand that lie on each other."""
    for track in scene.hair:
        for hair in filter(lambda shape: shape.sound, track):
            median = np.median(hair.lengths)
            short = hair.lengths <= COLLAPSED * median
            if short.any():
                message = f"strand {np.argmax(short)} has no length; {short.sum()} such"
                yield Fault(track.path("points"), f"{message}, drop them or keep their shape", hair.code)
                continue
            alike = _coincident(hair)
            if alike.any():
                message = f"points of strand {np.argmax(alike)} lie on each other; {alike.sum()} such strands"
                yield Fault(track.path("points"), f"{message}, which have no direction there", hair.code)


def _coincident(hair: Snapshot) -> np.ndarray:
    """Return which strands have two consecutive points in one place, (c,); ends doubled on purpose do not count."""
    mean = np.repeat(hair.lengths / (hair.counts - 1), hair.counts - 1)
    alike = hair.segments < COINCIDENT * mean
    if UsdGeom.BasisCurves(hair.prim).GetWrapAttr().Get() != UsdGeom.Tokens.pinned:
        firsts = hair.roots - np.arange(len(hair.counts))
        alike[firsts] = alike[firsts + hair.counts - 2] = False
    return hair.per_strand(np.logical_or, alike)


def spikes(scene: Scene) -> Iterator[Fault]:
    """Find strands of which one segment is far longer than all others: a point is somewhere else."""
    for track in scene.hair:
        for hair in filter(lambda shape: shape.sound, track):
            longest = hair.per_strand(np.maximum, hair.segments)
            others = (hair.lengths - longest) / np.maximum(hair.counts - 2, 1)
            spiked = (hair.counts > 3) & (longest > SPIKE * others) & (longest > COLLAPSED * np.median(hair.lengths))  # noqa: PLR2004
            if spiked.mean() > SOME:
                message = f"strand {np.argmax(spiked)} has a segment {SPIKE:g} times as long as its others"
                yield Fault(track.path("points"), f"{message}; {spiked.sum()} such strands", hair.code)


def rest(scene: Scene) -> Iterator[Fault]:
    """Find a rest pose in another unit than the hair, or of other strands."""
    for track in scene.hair:
        hair, still = track.first, _at_rest(track.first)
        if still is None or not hair.sound:
            continue
        lengths = still.lengths / np.maximum(hair.lengths, np.finfo(np.float64).tiny)
        ratio, apart = float(np.median(lengths)), (lengths < OTHER[0]) | (lengths > OTHER[1])
        if not REST[0] <= ratio <= REST[1]:
            message = f"has strands {ratio:.3g} times as long as points has; it is in the unit of the points"
            yield Fault(track.path("primvars:pref"), message)
        elif apart.mean() > SOME:
            message = f"strand {np.argmax(apart)} is {lengths[np.argmax(apart)]:.2g} times as long as in points"
            yield Fault(track.path("primvars:pref"), f"{message}; {apart.sum()} such strands, are they others?")


class _Still(Snapshot):
    """Hair at rest."""

    @property
    def points(self) -> np.ndarray:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return rest positions, (n, 3) float32."""
        pref = self.array("primvars:pref", 3)
        return np.empty((0, 3), np.float32) if pref is None else pref


def _at_rest(hair: Snapshot) -> Snapshot | None:
    still = _Still(hair.prim, hair.time)
    return still if still.sound else None


def stretch(scene: Scene) -> Iterator[Fault]:
    """Find strands that grow, shrink or tear: hair keeps its length."""
    for track in scene.hair:
        before = _reference(track)
        if before is None:
            continue
        for hair in filter(lambda shape: shape.sound and np.array_equal(shape.counts, before.counts), track):
            yield from _stretched(track, hair, before)


def _reference(track: Track) -> Snapshot | None:
    """Return the hair at rest, if that is its own, else as it is first."""
    hair, still = track.first, _at_rest(track.first)
    if not hair.sound:
        return None
    ours = still is not None and np.array_equal(still.counts, hair.counts)
    near = ours and REST[0] <= np.median(still.lengths / np.maximum(hair.lengths, 1e-30)) <= REST[1]
    return still if near else hair


def _stretched(track: Track, hair: Snapshot, before: Snapshot) -> Iterator[Fault]:
    tiny = np.finfo(np.float64).tiny
    ratio = float(np.median(hair.lengths / np.maximum(before.lengths, tiny)))
    if not STRETCH[0] <= ratio <= STRETCH[1]:
        yield Fault(track.path("points"), f"make strands {ratio:.3g} times as long as they were", hair.code)
        return
    parts = hair.segments / np.maximum(before.segments, tiny)
    minded = before.segments > EVEN * np.median(before.segments)
    torn = hair.per_strand(np.logical_or, minded & ((parts < TORN[0]) | (parts > TORN[1])))
    if torn.mean() > SOME:
        worst = hair.per_strand(np.maximum, np.where(minded, parts, 0))
        message = f"stretch segments of strand {np.argmax(torn)} to {worst[np.argmax(torn)]:.2g} times their length"
        yield Fault(track.path("points"), f"{message}; {torn.sum()} such strands", hair.code)


RULES = (
    Rule("collapsed", "error", collapsed),
    Rule("spike", "warning", spikes),
    Rule("rest", "error", rest),
    Rule("stretch", "error", stretch),
)
