"""Hair and guides on their way into a file for another program."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hairpipe.data import Body, Groom, Strands
from hairpipe.errors import BadInput

DIAMETER = 80e-6
"""Of hair where a groom has no widths [m]."""


@dataclass(frozen=True)
class GroomShot:
    """Contents of a file.

    groom    hair at rest, with guides marked in `guides`
    hair     all strands of the groom at every frame; None: at rest
    closest  ids of three guides of each strand, and their weights, (S, 3) each
    scalp    body at rest
    """

    groom: Groom
    hair: Mapping[int, Strands] | None
    closest: tuple[np.ndarray, np.ndarray] | None
    scalp: Body | None
    fps: float

    def pieces(self, apart: bool) -> dict[str, np.ndarray]:
        """Return the strands, (n,), of each object: hair, and guides where they are apart."""
        guides = np.zeros(len(self.groom.ids), bool) if self.groom.guides is None else self.groom.guides
        masks = {"hair": ~guides, "guides": guides} if apart else {"hair": np.ones(len(guides), bool)}
        return {name: np.flatnonzero(mask) for name, mask in masks.items() if mask.any()}

    def widths(self, rows: np.ndarray) -> np.ndarray:
        """Return diameters at some points, (p,) [m]: of the hair where they vary, else of the groom, if it has any."""
        first = None if not self.hair else self.hair[next(iter(self.hair))]
        if first is not None and (first.widths is not None or self.groom.widths is None):
            return first.widths_at_points()[rows]
        return np.full(len(rows), DIAMETER) if self.groom.widths is None else self.groom.widths[rows]

    def rows(self, strands: np.ndarray) -> np.ndarray:
        """Return the points of some strands, ascending, (p,)."""
        chosen = np.isin(np.arange(len(self.groom.ids)), strands)
        return np.flatnonzero(np.repeat(chosen, np.diff(self.groom.offsets)))

    def at(self, frame: int) -> Strands:
        """Return the hair at a frame; BadInput for other strands than the groom's, or points that are not finite."""
        where = f"hair at frame {frame}"
        hair = (self.hair or {}).get(frame)
        if hair is None or not np.array_equal(hair.offsets, self.groom.offsets):
            raise BadInput("the groom does not have the strands of the hair", where=where, right="what was simulated")
        if not np.isfinite(hair.points).all():
            raise BadInput("points are not all finite", where=where, right="finite numbers")
        return hair
