"""The hair of a shot: a groom as a model of strands."""

from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import blake2b
from typing import Literal
from warnings import warn

import numpy as np

from hairpipe.data import Groom
from hairpipe.data.lengths import strand_lengths
from hairpipe.errors import BadInput
from hairpipe.groom.binding import name_strands
from hairpipe.sim.layout import Layout, lay_out
from hairpipe.sim.material import Material
from hairpipe.sim.strands import chain, network
from hairpipe.sim.strands.calibration import softenings
from hairpipe.sim.strands.chain import Chain, build_chain
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.network import Network, build_network

ModelName = Literal["network", "chain"]
Precision = Literal["double", "single"]
DTYPES = {"double": np.float64, "single": np.float32}
AS_IT_WORKS = Construction()


@dataclass(frozen=True, eq=False)
class Hair:
    """What stays the same through a shot: the groom as a model of strands.

    rest  particles of the groom in the world [m], (rows, 3, W) float64
    """

    groom: Groom
    layout: Layout
    model: Network | Chain
    rest: np.ndarray
    diameter: float


def make_hair(
    groom: Groom,
    material: Material,
    name: ModelName = "network",
    construction: Construction = AS_IT_WORKS,
    precision: Precision = "double",
) -> Hair:
    """Build the model of a groom's strands; BadInput naming strands with a segment that has no length, or hardly any.

    The last two are remembered by their contents: every frame of a shot gets a groom of its own that is the same.
    """
    return _make_hair(Contents(groom), material, name, construction, precision)


@dataclass(frozen=True)
class Contents:
    """A groom that equals another one when all its arrays do."""

    groom: Groom = field(compare=False)
    digest: bytes = field(init=False)

    def __post_init__(self) -> None:
        digest = blake2b()
        for name in Groom.__dataclass_fields__:
            known = getattr(self.groom, name)
            values = np.ascontiguousarray([] if known is None else known)
            digest.update(f"{name} {values.dtype} {values.shape}".encode())
            digest.update(values.data)
        object.__setattr__(self, "digest", digest.digest())


@lru_cache(maxsize=2)
def _make_hair(
    contents: Contents, material: Material, name: ModelName, construction: Construction, precision: Precision
) -> Hair:
    groom, dtype = contents.groom, DTYPES[precision]
    check_segments(groom)
    if name == "chain":
        layout = lay_out(groom.offsets, chain.SHAPE, dtype)
        model, rest = build_chain(layout, groom.points, material)
    else:
        check_lengths(groom, material)
        layout = lay_out(groom.offsets, network.SHAPE, dtype)
        model, rest = build_network(layout, groom.points, groom.root_frames, material, construction)
    return Hair(groom, layout, model, rest, material.diameter)


def mean_segments(groom: Groom) -> np.ndarray:
    """Return the mean length of the segments of every strand [m], (S,); pure."""
    return strand_lengths(groom.points, groom.offsets) / (np.diff(groom.offsets) - 1)


def check_lengths(groom: Groom, material: Material) -> None:
    """Refuse strands whose segments are too short to be springs of a material, by BadInput with their ids."""
    lengths = mean_segments(groom)
    short = softenings(material, lengths) < 1.0
    if short.any():
        size = f"segments of {lengths[short].min():.2g} m, hair of {material.diameter:g} m"
        raise BadInput(
            f"{size}: {name_strands(groom.ids[short])}",
            where="groom",
            right="segments longer than hair is thick: fewer of them, or those strands left out",
        )


def warn_of_softening(groom: Groom, material: Material) -> None:
    """Tell which strands are softened less than the material is, as their segments are too short for that."""
    found = softenings(material, mean_segments(groom))
    less = found < material.softening
    if less.any():
        said = f"{np.count_nonzero(less)} of {len(less)} strands have segments too short for it and are softened less"
        worst = f"by {found.min():.3g} at least: {name_strands(groom.ids[less])}"
        warn(f"material.softening = {material.softening:g}: {said}, {worst}", stacklevel=3)


def check_segments(groom: Groom) -> None:
    """Refuse strands with a point that is not finite or on the one before it, by BadInput with their ids."""
    lengths = np.linalg.norm(np.diff(groom.points, axis=0), axis=1)
    inside = np.delete(np.arange(len(lengths)), groom.offsets[1:-1] - 1)
    wrong = inside[~(lengths[inside] > 0.0) | ~np.isfinite(lengths[inside])]
    if len(wrong):
        ids = groom.ids[np.unique(np.searchsorted(groom.offsets, wrong, side="right") - 1)]
        raise BadInput(
            f"segments without length, or points that are not finite: {name_strands(ids)}",
            where="groom",
            right="every point away from the one before it",
        )
