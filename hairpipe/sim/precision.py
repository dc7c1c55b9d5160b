"""When hair is computed in single precision: the tool chooses, from what hair touches, its steps, stiffness and mass.

The matrix of an implicit step has stiffness beside mass, h^2 k to m, and what is lost when one is eliminated from the
other grows with that: with the square of how many explicit steps there are in a step,

    N = dt sqrt(max_p sum_s 4 k_s / (m_p l_s)),

the sum running over the springs s at a particle p. At N = 4,000, rounding, 6e-8 N^2, is as great as mass is; a tenth of
that N is allowed. `graphs/experiments/precision.toml` measures what it does at N = 395: hair that touches nothing is as
good as in double, in half the time; hair on a body is three times as far off and saves nothing, for the time goes
into probing the body; hair among hair saves a tenth, and goes ways of its own. So hair that may touch anything
stays in double precision, as does hair that stands without sag, whose springs cancel. What is exchanged between
strands, and their factors there, are in single precision whatever this says: nothing is eliminated any more.

A frame is computed about the middle of the roots (`roots.origin_of`), and positions between frames are in double
precision: single precision rounds them to 6e-8 of the way from there, wherever in the world that is.
"""

from functools import lru_cache
from typing import Literal
from warnings import warn

from hairpipe.data import Groom
from hairpipe.errors import BadInput
from hairpipe.sim.hair_model import Contents, Hair, ModelName, make_hair, warn_of_softening
from hairpipe.sim.integrators.step_size import highest_frequency
from hairpipe.sim.material import Material
from hairpipe.sim.settings import Scene
from hairpipe.sim.strands.construction import Construction

PrecisionAsked = Literal["automatic", "double", "single"]
MOST = 400.0
"""Of N, in single precision."""


def hair_in(
    asked: PrecisionAsked,
    groom: Groom,
    material: Material,
    name: ModelName,
    construction: Construction,
    scene: Scene,
    *,
    bodies: bool,
    first: bool = False,
) -> Hair:
    """Build the model of a groom's strands in the precision asked for, or in the one that is enough for the scene.

    BadInput as for `make_hair`, and where single precision was asked for and cannot do. A warning says where it was
    chosen, and where it was asked for and is not safe.

    bodies  that hair may touch are there
    first   frame of a shot: the one that warns
    """
    if first and name == "network":
        warn_of_softening(groom, material)
    if asked == "single" and scene.sag_free is not None:
        said = "a start without sag cannot be found in single precision"
        raise BadInput(said, where="precision", right='"automatic" or "double"')
    if asked == "double":
        return make_hair(groom, material, name, construction)
    needs = needs_double(scene, bodies)
    steps = 0.0 if needs else scene.steps.longest * _highest_frequency(Contents(groom), material, name, construction)
    if steps > MOST:
        longest = scene.steps.longest * MOST / steps
        needs = f"steps beyond {longest:.2g} s of hair so stiff and light"
    if first and not needs and asked == "automatic":
        said = f"hair touches nothing, and there are {steps:.0f} explicit steps in a step, of {MOST:.0f} allowed"
        warn(f'computed in single precision: {said} (precision = "double" for more)', stacklevel=2)
    if first and needs and asked == "single":
        warn(f'single precision is too little for {needs}: precision = "automatic" takes double', stacklevel=2)
    single = asked == "single" or not needs
    return make_hair(groom, material, name, construction, "single" if single else "double")


def needs_double(scene: Scene, bodies: bool) -> str:
    """Find what in a scene needs double precision, whatever its steps are; empty where nothing does."""
    if bodies:
        return "hair that touches a body"
    if scene.stiction is not None or scene.collisions is not None:
        return "hair that touches hair"
    return "a start without sag" if scene.sag_free is not None else ""


@lru_cache(maxsize=2)
def _highest_frequency(contents: Contents, material: Material, name: ModelName, construction: Construction) -> float:
    """Bound what a groom's springs swing with [rad/s]; remembered as hair is."""
    return highest_frequency(make_hair(contents.groom, material, name, construction).model)
