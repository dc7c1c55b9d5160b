"""A shape over time, one frame of it in memory at a time."""

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np
from pxr import Usd, Vt

from hairpipe.io.usd.check.snapshot import Snapshot

REST = (2 / 3, 3 / 2)
"""Accepted lengths at rest over those at the first time: a rest pose in the unit of the points."""


def notes_of(stage: Usd.Stage) -> dict[str, Any]:
    """Return our notes in a stage; none in the stage of another program."""
    notes = stage.GetRootLayer().customLayerData.get("hairpipe")
    return notes if isinstance(notes, dict) else {}


class Track:
    """A shape over time.

    prim   curves or a mesh
    times  codes of all samples; empty for a constant shape
    """

    def __init__(self, prim: Usd.Prim) -> None:
        self.prim = prim
        self.times = sorted({time for attribute in prim.GetAttributes() for time in attribute.GetTimeSamples()})

    def at(self, time: float | None) -> Snapshot:
        """Return the shape at a time code, or a constant shape."""
        return Snapshot(self.prim, Usd.TimeCode.Default() if time is None else Usd.TimeCode(time))

    def path(self, name: str) -> str:
        """Return the path of an attribute, for messages."""
        return f"{self.prim.GetPath()}.{name}"

    def __iter__(self) -> Iterator[Snapshot]:
        """Yield the shape at every time, read on demand."""
        return (self.at(time) for time in self.times or [None])

    @cached_property
    def first(self) -> Snapshot:
        """Return the shape at its first time."""
        return self.at(self.times[0] if self.times else None)

    @cached_property
    def points(self) -> list[float]:
        """Return the codes at which the points have samples."""
        return self.prim.GetAttribute("points").GetTimeSamples()

    @cached_property
    def cuts(self) -> list[float]:
        """Return the time codes at which the shot is cut, from our notes."""
        cuts = notes_of(self.prim.GetStage()).get("cuts")
        return [float(cut) for cut in cuts] if cuts and isinstance(cuts, Vt.IntArray) else []

    def is_cut(self, before: Snapshot, after: Snapshot) -> bool:
        """Return whether the shot is cut between two times."""
        return any(before.time.GetValue() < cut <= after.time.GetValue() for cut in self.cuts)

    @property
    def moves(self) -> bool:
        """Return whether its points have samples at more than one time."""
        return len(self.points) > 1

    @cached_property
    def still(self) -> Snapshot | None:
        """Return hair in its rest pose; None where rest pose or hair is missing or invalid."""
        still = Still(self.prim, self.first.time)
        return still if still.sound and self.first.sound else None

    @cached_property
    def growth(self) -> np.ndarray:
        """Return the lengths of strands at rest over those at the first time, (c,); 1 where there is no rest."""
        if self.still is None:
            return np.ones(len(self.first.counts))
        return self.still.lengths / np.maximum(self.first.lengths, np.finfo(np.float64).tiny)

    @cached_property
    def reference(self) -> Snapshot | None:
        """Return hair in its own rest pose, else at its first time; None where it is invalid."""
        near = self.still is not None and REST[0] <= np.median(self.growth) <= REST[1]
        return self.still if near else self.first if self.first.sound else None


class Still(Snapshot):
    """Hair at rest."""

    @cached_property
    def points(self) -> np.ndarray:
        """Return rest positions, (n, 3) float32."""
        pref = self.array("primvars:pref", 3)
        return np.empty((0, 3), np.float32) if pref is None else pref
