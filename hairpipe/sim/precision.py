"""When hair is computed in single precision: the tool chooses, from what hair touches, its steps, stiffness and mass.

The matrix of an implicit step has stiffness in addition to mass, h^2 k to m, and what is lost when one is eliminated
from the other grows with that: with the square of how many explicit steps there are in a step,

    N = dt sqrt(max_p sum_s 4 k_s / (m_p l_s)),

the sum running over the springs s at a particle p. At N = 4,000, rounding, 6e-8 N^2, is as great as mass is. What that
does to hair that touches nothing depends on the model: hair of 25 cm in a shake has an error of 22 % of its length as a
network at N = 1,650, and as a rod at N = 740 by 0.001 % more than in double precision
(`graphs/experiments/precision.toml`). So the largest N allowed is a property of the model, `ModelKind.single_limit`. At
that limit rounding moves falling hair by less than the error of a step of 1/240 s (`tests/sim/test_precision.py`).

Hair on a body is three times as far off as in double and saves nothing, for the time goes into probing the body; hair
among hair saves a tenth, and goes ways of its own. So hair that may touch anything stays in double precision, as does
hair that stands without sag, whose springs cancel. What is exchanged between strands, and their factors there, are in
single precision whatever this says: nothing is eliminated any more.

A frame is computed about the middle of the roots (`boundary.origin_of`), and positions between frames are in double
precision: single precision rounds them to 6e-8 of the way from there, wherever in the world that is.
"""

from typing import Literal
from warnings import warn

from hairpipe.errors import BadInput
from hairpipe.sim.hair_model import HairModel, HairModels
from hairpipe.sim.settings import Scene

PrecisionAsked = Literal["automatic", "double", "single"]


def choose_precision(
    asked: PrecisionAsked, models: HairModels, scene: Scene, *, bodies: bool, first: bool = False
) -> HairModel:
    """Return strands in the precision asked for, or in the one that is enough for the scene.

    bodies  that hair may touch are there
    first   frame of a shot: the one that warns

    Warns where single precision was chosen, and where it was asked for and is not safe. Raises BadInput as
    `HairModels.in_precision` does, and where single precision was asked for and cannot do.
    """
    if first:
        models.kind.warn(models.groom, models.material)
    if asked == "single" and scene.sag_free is not None:
        said = "a sag-free start is impossible in single precision"
        raise BadInput(said, where="precision", right='"automatic" or "double"')
    if asked == "double":
        return models.in_precision("double")
    needs = needs_double(scene, bodies)
    steps = 0.0 if needs else scene.steps.longest * models.highest_frequency
    limit = models.kind.single_limit
    if steps > limit:
        longest = scene.steps.longest * limit / steps
        needs = f"steps beyond {longest:.2g} s of hair so stiff and light"
    if first and not needs and asked == "automatic":
        said = f"hair without contact takes {steps:.0f} explicit steps per step, of {limit:.0f} allowed"
        warn(f'computed in single precision: {said} (precision = "double" is more accurate)', stacklevel=2)
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
