"""Constants of a shot: its groom as a model of strands."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Literal, TypeVar

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.laws.settings import Construction
from hairpipe.strands.interface import ModelKind, StrandModel
from hairpipe.strands.layout import Layout, axis_of, following_masses, lay_out
from hairpipe.strands.material import Fibres, Material, VariedMaterial, fibres_of
from hairpipe.strands.network import highest_frequency
from hairpipe.strands.registry import ModelName, strand_models
from hairpipe.values import Groom
from hairpipe.values.groom import segment_lengths
from hairpipe.values.painting import ReadImage, Varied, values_of
from hairpipe.values.strand_arrays import name_strands

T = TypeVar("T")
Precision = Literal["double", "single"]
DTYPES = {"double": np.float64, "single": np.float32}
DEFAULT = Construction()


@dataclass(frozen=True, eq=False)
class HairModel:
    """The strand model of a groom.

    rest      particles of the groom in the world [m], (rows, 3, W) float64
    diameter  mean diameter of hairs [m]
    diameters  diameters at points where they vary, (P,) float32 [m]
    widths    square root of the number of hairs that a segment represents, (P,): contact distances are scaled by it,
              wind shielding by its square; None: 1
    part_of   the model of all strands of which these are a subset, and the index here of each of its points, -1:
              absent, (P,)
    in_double builds the same strands in double precision; None if these are
    read_image  reads the images of settings of a scene that vary; None: these have none
    """

    groom: Groom
    layout: Layout
    model: StrandModel
    rest: np.ndarray
    diameter: float
    widths: np.ndarray | None = None
    part_of: "tuple[HairModel, np.ndarray] | None" = None
    in_double: "Callable[[], HairModel] | None" = None
    read_image: ReadImage | None = None
    diameters: np.ndarray | None = None
    _found: dict[Hashable, Any] = field(default_factory=dict, init=False)

    def once(self, key: Hashable, find: Callable[[], T]) -> T:
        """Return what `find` returns, called when a key is first asked for: constants of a shot that a scene needs."""
        if key not in self._found:
            self._found[key] = find()
        return self._found[key]

    @property
    def masses(self) -> np.ndarray:
        """Mass that moves with each point [kg], (P,)."""
        return self.once("masses", lambda: following_masses(axis_of(self.layout), self.model.mass))

    def values_of(self, setting: Varied, name: str) -> Any:
        """Return a setting at points and on segments, as the function of this name; of a part, as the whole has it."""
        if self.part_of is None:
            return self.once((name, setting), lambda: values_of(setting, self.groom, name, self.read_image))
        whole, numbers = self.part_of
        values = whole.values_of(setting, name)
        return values[:, numbers >= 0] if np.ndim(values) else values


@dataclass(frozen=True, eq=False)
class HairModels:
    """The strands of a groom in single precision and in double, each built when it is first asked for, and kept.

    shape  share of the curvature of the groom at rest, at all points, or at points, (P,)
    """

    groom: Groom
    fibres: Fibres
    kind: ModelKind
    construction: Construction = DEFAULT
    read_image: ReadImage | None = None
    shape: float | np.ndarray = 1.0
    _built: dict[Precision, HairModel] = field(default_factory=dict, init=False)

    def in_precision(self, precision: Precision) -> HairModel:
        """Return the strands in a precision.

        Raises BadInput naming strands with a segment of zero length, and the errors of the kind of model.
        """
        if precision not in self._built:
            check_segments(self.groom)
            layout = lay_out(self.groom.offsets, self.kind.shape, DTYPES[precision])
            model, rest = self.kind.build(layout, self.groom, self.fibres, self.construction, self.shape)
            finer = partial(self.in_precision, "double") if precision == "single" else None
            more = {"in_double": finer, "read_image": self.read_image, "diameters": self.fibres.widths}
            self._built[precision] = HairModel(self.groom, layout, model, rest, self.fibres.diameter, **more)
        return self._built[precision]

    @cached_property
    def highest_frequency(self) -> float:
        """Bound of what the springs swing with [rad/s]."""
        return highest_frequency(self.in_precision("double").model)


def build_models(
    groom: Groom,
    material: Material | VariedMaterial,
    model: ModelName,
    construction: Construction = DEFAULT,
    read_image: ReadImage | None = None,
    shape: Varied | float = 1.0,
) -> HairModels:
    """Model the strands of a groom by a model of the house, with a share of its curvature at rest.

    Raises BadInput as `fibres_of` and `values_of`.
    """
    fibres = fibres_of(groom, material, read_image)
    shares = values_of(shape, groom, "rest.shape", read_image)
    shares = shares if np.ndim(shares) == 0 else shares[0]
    return HairModels(groom, fibres, strand_models()[model], construction, read_image, shares)


def build_hair(
    groom: Groom,
    material: Material | VariedMaterial,
    model: ModelName,
    construction: Construction = DEFAULT,
    precision: Precision = "double",
) -> HairModel:
    """Model the strands of a groom in one precision; BadInput as for `HairModels.in_precision`."""
    return build_models(groom, material, model, construction).in_precision(precision)


UNEQUAL = 1.5
"""Longest segment over the shortest from which a strand is refused; strands deformed by hand keep well below."""


def check_segments(groom: Groom) -> None:
    """Refuse strands with a point that is not finite or on the one before it, or with unequal segments, by BadInput.

    A model has one stiffness of a segment for a whole strand, calibrated for segments of one length.
    """
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
    lengths = segment_lengths(groom.points, groom.offsets)
    starts = groom.offsets[:-1] - np.arange(len(groom.ids))
    longest, shortest = (pick.reduceat(lengths, starts) for pick in (np.maximum, np.minimum))
    if (longest > UNEQUAL * shortest).any():
        s = int(np.argmax(longest / shortest))
        what = f"segments of strand {groom.ids[s]} are {1e3 * shortest[s]:.2g} to {1e3 * longest[s]:.2g} mm long"
        right = 'equal segments, as of load_groom with points = "equal"'
        raise BadInput(what, where="groom", right=right)
