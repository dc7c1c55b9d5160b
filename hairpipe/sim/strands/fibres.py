"""Fibres of a groom: stiffness and mass at its points and on its segments, from settings that may vary."""

from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from hairpipe.data import Groom
from hairpipe.groom.painting.paint import ReadImage
from hairpipe.groom.painting.variation import values_of
from hairpipe.sim.material import Material, RoundFibre, VariedMaterial


class Section(NamedTuple):
    """Stiffness and mass of fibres, arrays of one shape, as of `RoundFibre`; softening of all."""

    axial: np.ndarray
    bending: np.ndarray
    torsion: np.ndarray
    line_density: np.ndarray
    softening: float


def taken(section: Section, some: np.ndarray) -> Section:
    """Return the sections of some strands, the first axis of all arrays; pure."""
    return Section(*(values[some] for values in section[:-1]), section.softening)


class Fibre(NamedTuple):
    """Fibres of strands of n segments: at their points, (s, n+1), and on their segments, (s, n)."""

    points: Section
    segments: Section


class Fibres(NamedTuple):
    """The fibres of a groom; of each quantity one number, or values at points and on the segments after them, (2, P).

    diameter  mean diameter [m]
    widths    diameters at points where they vary, (P,) float32 [m]
    """

    axial: Any
    bending: Any
    torsion: Any
    line_density: Any
    softening: float
    diameter: float
    widths: np.ndarray | None = None

    def of(self, points: np.ndarray) -> Fibre:
        """Return the fibres of strands whose points are in the groom at places, (s, n+1) int, or (P,)."""
        given = (self.axial, self.bending, self.torsion, self.line_density)
        over = [v[:, points] if isinstance(v, np.ndarray) else np.broadcast_to(v, (2, *points.shape)) for v in given]
        on_segments = (values[1, ..., :-1] for values in over)
        return Fibre(Section(*(v[0] for v in over), self.softening), Section(*on_segments, self.softening))


def fibres_of(groom: Groom, material: Material | VariedMaterial, read_image: ReadImage | None = None) -> Fibres:
    """Return the fibres of a groom; BadInput as `values_of`."""
    fibre = RoundFibre()
    for field in fields(material):
        of = values_of(getattr(material, field.name), groom, f"material.{field.name}", read_image)
        setattr(fibre, field.name, of)
    found = Fibres(fibre.axial, fibre.bending, fibre.torsion, fibre.line_density, fibre.softening, fibre.diameter)
    if np.ndim(fibre.diameter) == 0:
        return found
    widths = fibre.diameter[0]
    return found._replace(diameter=float(np.mean(widths)), widths=widths.astype(np.float32))
