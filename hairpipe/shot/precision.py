"""Choice of single precision from the contacts of hair, its steps, stiffness and mass.

The matrix of an implicit step adds the stiffness h^2 k to the mass m, and the rounding error of the elimination grows
with their ratio: with the square of the number of explicit steps in a step,

    N = dt sqrt(max_p sum_s 4 k_s / (m_p l_s)),

the sum running over the springs s at a particle p. At N = 4,000 the rounding error, 6e-8 N^2, equals the mass. For
hair without contact the effect depends on the model: hair of 25 cm in a shake has an error of 22 % of its length as a
network at N = 1,650; as a rod at N = 740 the error is 0.001 % larger than in double precision
(`graphs/experiments/precision.toml`). So the largest N allowed is a property of the model, `ModelKind.single_limit`. At
that limit rounding moves falling hair by less than the error of a step of 1/240 s (`tests/shot/test_precision.py`).

Hair on a body has three times the error of double precision and saves no time, since queries of the body dominate;
hair in contact with hair saves a tenth, and its trajectories diverge. So hair with possible contacts is computed in
double precision, as is sag-free hair, whose springs cancel. Couplings between strands and the factors used there are
always in single precision: they take no part in an elimination.

A frame is computed about the middle of the roots (`boundary.origin_of`), and positions between frames are in double
precision: single precision rounds them to 6e-8 of the distance from that middle, anywhere in the world.
"""

from typing import Literal
from warnings import warn

from hairpipe.errors import BadInput
from hairpipe.shot.settings import Scene
from hairpipe.strands.hair_model import HairModel, HairModels

PrecisionAsked = Literal["automatic", "double", "single"]


def choose_precision(
    asked: PrecisionAsked, models: HairModels, scene: Scene, *, bodies: bool, first: bool = False
) -> HairModel:
    """Return strands in the requested precision, or in the one that suffices for the scene.

    bodies  whether there are bodies that hair may touch
    first   whether this is the first frame of a shot, at which warnings are emitted

    Warns if single precision was chosen, and if it was requested but is not safe. Raises BadInput as
    `HairModels.in_precision`, and if single precision was requested but is impossible.
    """
    if first:
        models.kind.warn(models.groom, models.fibres)
    if asked == "single" and scene.sag_free is not None:
        message = "a sag-free start is impossible in single precision"
        raise BadInput(message, where="precision", right='"automatic" or "double"')
    if asked == "double":
        return models.in_precision("double")
    needs = needs_double(scene, bodies)
    steps = 0.0 if needs else scene.steps.longest * models.highest_frequency
    limit = models.kind.single_limit
    if steps > limit:
        longest = scene.steps.longest * limit / steps
        needs = f"steps beyond {longest:.2g} s of hair so stiff and light"
    if first and not needs and asked == "automatic":
        message = f"hair without contact takes {steps:.0f} explicit steps per step, of {limit:.0f} allowed"
        warn(f'computed in single precision: {message} (precision = "double" is more accurate)', stacklevel=2)
    if first and needs and asked == "single":
        warn(f'single precision is insufficient for {needs}: precision = "automatic" uses double', stacklevel=2)
    return models.in_precision("single" if asked == "single" or not needs else "double")


def needs_double(scene: Scene, bodies: bool) -> str:
    """Find what in a scene needs double precision, whatever its steps are; empty where nothing does."""
    if bodies:
        return "hair that touches a body"
    if scene.stiction is not None or scene.collisions is not None:
        return "hair that touches hair"
    return "a start without sag" if scene.sag_free is not None else ""
