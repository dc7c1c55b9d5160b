"""Hair and guides on their way into a file for another program."""

import re
import warnings
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Body, Groom, Strands
from hairpipe.values.groom import drawn_widths

DIAMETER = 80e-6
"""Of hair where a groom has no widths [m]."""


@dataclass(frozen=True)
class GroomShot:
    """Contents of a file.

    groom    hair at rest, with guides marked in `guides`
    hair     all strands of the groom at every frame; None: at rest
    closest  ids of three guides of each strand, and their weights, (S, 3) each
    scalp    body at rest
    hairs    number of hairs that the strands represent in a picture; None: widths are diameters
    """

    groom: Groom
    hair: Mapping[int, Strands] | None
    closest: tuple[np.ndarray, np.ndarray] | None
    scalp: Body | None
    fps: float
    hairs: int | None = None

    def pieces(self, apart: bool) -> dict[str, np.ndarray]:
        """Return the strands, (n,), of each object: hair, and guides where they are apart."""
        guides = np.zeros(len(self.groom.ids), bool) if self.groom.guides is None else self.groom.guides
        masks = {"hair": ~guides, "guides": guides} if apart else {"hair": np.ones(len(guides), bool)}
        return {name: np.flatnonzero(mask) for name, mask in masks.items() if mask.any()}

    def first(self) -> Strands | None:
        return None if not self.hair else self.at(next(iter(self.hair)))

    def widths(self, hair: Strands | None) -> np.ndarray:
        """Return widths at all points, (p,) [m]: diameters, or widths with which the strands represent more hairs."""
        diameters = self.diameters(hair)
        if self.hairs is None:
            return diameters
        guides = 0 if self.groom.guides is None else np.count_nonzero(self.groom.guides)
        drawn = len(self.groom.ids) - guides or guides
        return drawn_widths(diameters, self.groom.offsets, self.hairs / drawn)

    def diameters(self, hair: Strands | None) -> np.ndarray:
        """Return diameters at all points, (p,) [m].

        They are those of the hair at a frame where they vary along it, else of the groom, if it has any.
        """
        if hair is not None and (hair.widths is not None or self.groom.widths is None):
            return hair.widths_at_points()
        return np.full(len(self.groom.points), DIAMETER) if self.groom.widths is None else self.groom.widths

    def maps(self, taken: Collection[str]) -> dict[str, np.ndarray]:
        """Return the maps of the groom, (S,) each, by their names in the file; warn of names that are other ones there.

        taken  names with another meaning
        Raises BadInput where a map would have one of them, or that of another map.
        """
        found = dict[str, np.ndarray]()
        for name, values in self.groom.maps.items():
            parts = (re.sub(r"\W", "_", part) for part in name.split(":"))  # letters, digits and _, no digit first
            written = ":".join(part if part.isidentifier() else f"_{part}" for part in parts)
            if written in taken or written in found:
                what = f"the map '{name}' of the groom has the name of another attribute, {written}"
                raise BadInput(what, where="groom", right="another name")
            if written != name:
                warnings.warn(f"the map '{name}' of the groom is written as {written}", stacklevel=3)
            found[written] = values
        return found

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
