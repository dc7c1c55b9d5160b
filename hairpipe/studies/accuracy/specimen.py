"""One strand to measure: the network that the simulation would build for it, and the forces of its kernels."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hairpipe.kernels.simd import width
from hairpipe.sim.layout import lay_out
from hairpipe.sim.material import Material
from hairpipe.sim.strands.network import SHAPE, Network, build_network
from hairpipe.studies.accuracy.sample import Sample

_LANES = width(np.float64)


@dataclass(frozen=True, eq=False)
class Specimen:
    """A strand of n segments.

    model     its network, the same in every lane
    rest      particles at rest [m], (2n+3, 3)
    mass      of the particles [kg], (2n+3,)
    material  that it is made of
    """

    model: Network
    rest: np.ndarray
    mass: np.ndarray
    material: Material

    @cached_property
    def segment(self) -> float:
        """Length of a segment [m]."""
        return float(np.linalg.norm(self.rest[2] - self.rest[0]))

    @cached_property
    def segments(self) -> int:
        """Number of free segments."""
        return len(self.rest) // 2 - 1


def straight_specimen(sample: Sample, segments: int) -> Specimen:
    """Make a straight strand from the origin along +Z."""
    return specimen_of(sample, np.arange(segments + 1)[:, None] * [0.0, 0.0, sample.length / segments])


def specimen_of(sample: Sample, points: np.ndarray) -> Specimen:
    """Make a strand of points at equal distances [m], (n+1, 3)."""
    layout = lay_out(np.array([0, len(points)], np.int32), SHAPE)
    model, rest = build_network(
        layout, np.asarray(points, float), np.eye(3)[None], sample.material, sample.construction
    )
    if sample.constants == "guessed":
        unit = sample.material.bending / np.linalg.norm(points[1] - points[0]) ** 2
        model.constants[:, 1:] = unit * np.array([1.0, 1.0, sample.construction.altitude])[:, None]
    return Specimen(model, rest[:, :, 0].copy(), model.mass[:, 0].copy(), sample.material)


def forces(specimen: Specimen, positions: np.ndarray) -> np.ndarray:
    """Forces of all springs [N], (lanes, particles, 3), for particles that stand at positions [m] of the same shape."""
    from hairpipe.sim.statics.hessian import spring_forces

    found = np.empty_like(positions)
    for first in range(0, len(positions), _LANES):
        some = positions[first : first + _LANES]
        lanes = np.concatenate([some, np.repeat(some[-1:], _LANES - len(some), axis=0)])
        found[first : first + _LANES] = spring_forces(specimen.model, 0, np.moveaxis(lanes, 0, 2).copy()).transpose(
            2, 0, 1
        )[: len(some)]
    return found
