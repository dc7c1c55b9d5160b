"""A groom at rest under gravity."""

from dataclasses import replace

import numpy as np

from hairpipe.data import Groom
from hairpipe.errors import BadInput
from hairpipe.groom.painting.paint import ReadImage
from hairpipe.sim.build import gravity_of
from hairpipe.sim.hair_model import build_models
from hairpipe.sim.material import VariedMaterial
from hairpipe.sim.settings import Scene
from hairpipe.sim.statics.settle import settle
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.registry import ModelName


def settle_groom(
    groom: Groom,
    material: VariedMaterial,
    construction: Construction,
    gravity: float,
    model: ModelName,
    read_image: ReadImage | None = None,
) -> Groom:
    """Return the groom with its strands at rest under gravity, with springs at rest as groomed.

    gravity  along -Y [m/s^2]
    model    of a strand

    A warning names strands that do not come to rest. Raise BadInput where the body holds tips.
    """
    if groom.tip_triangles is not None:
        raise BadInput("tips held by the body would be released", where="in.groom", right="a groom of free tips")
    hair = build_models(groom, material, model, construction, read_image).in_precision("double")
    everyone = np.ones(hair.layout.strands.shape, bool)
    settled = settle(hair.model, hair.layout, groom.ids, hair.rest, gravity_of(Scene(gravity)), everyone)
    return replace(groom, points=hair.layout.axis(settled.positions))
