"""The hair simulation: every strand of the groom, carried by the body or by its ends."""

# ruff: noqa: B008 (settings are frozen)

from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from hairpipe.data import BodyParts, Ends, Groom, LevelSet, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.graph import Pair, Time, node
from hairpipe.sim import settings as of
from hairpipe.sim.air.wind import Wind
from hairpipe.sim.material import Material
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.registry import ModelName
from hairpipe.units import Interval, MetresPerSecondSquared

if TYPE_CHECKING:
    from hairpipe.sim.hair_model import HairModels


class Hair(NamedTuple):
    """Strands to look at, and the state the next frame starts from."""

    strands: Strands
    state: HairState


def model_strands(groom: Groom, material: Material, model: ModelName, construction: Construction) -> "HairModels":
    """Model the strands of a groom, for the whole shot."""
    from hairpipe.sim.hair_model import build_models

    return build_models(groom, material, model, construction)


@node(frames="scan", prepare=model_strands)
def simulate_hair(
    groom: Groom,
    body: Pair[Mesh] | None,
    surface: tuple[Pair[LevelSet], ...] | None,
    parts: tuple[Pair[BodyParts], ...] | None,
    ends: Pair[Ends] | None,
    previous: HairState | None,
    time: Time,
    prepared: "HairModels",
    *,
    model: ModelName = "network",
    precision: Literal["automatic", "double", "single"] = "automatic",
    material: Material = Material(),
    construction: Construction = Construction(),
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
    air: of.Air = of.Air(),
    contact: of.BodyContact = of.BodyContact(),
    strain: of.StrainLimit | None = None,
    steps: of.StepControl = of.StepControl(),
    scheme: of.Scheme = of.Scheme(),
    sag_free: of.SagFree | None = None,
    stiction: of.Stiction | None = None,
    collisions: of.Collisions | None = None,
    wind: Wind | None = None,
    cuts: tuple[int, ...] = (),
) -> Hair:
    """Mass-spring hair after Selle, Lentine, Fedkiw 2008: every strand a network of springs, solved at once.

    model         network: as published; chain: straight hair without twist, at half the particles
    precision     of the numbers; automatic: single where that is safe, see `sim/precision.py`
    material      of the fibre; the spring constants are calibrated from it
    construction  of the network, to take apart what it consists of
    gravity       along -Y
    air           what slows the hair where nothing touches it
    contact       how it touches bodies, whole level sets and those in parts; without any it passes through
    strain        how far a segment may be stretched; without, as far as its springs let it
    steps         how a frame is cut into steps
    scheme        how a step is computed
    sag_free      start at rest as groomed; without, springs rest in the groom's shape and hair sags from it
    stiction      hair that came close sticks together until it is pulled apart
    collisions    hair pushes hair away and does not pass through it
    wind          moving air; without, it is still
    cuts          frames at which a shot begins anew: hair is carried over with its roots, without the way there
    """
    from hairpipe.sim.boundary import lead_of
    from hairpipe.sim.precision import choose_precision
    from hairpipe.sim.simulate import Frame, next_state, strands_of

    scene = of.Scene(gravity, air, contact, strain, steps, scheme, sag_free, stiction, collisions, wind)
    solid, leads = bool(surface or parts), lead_of(body, ends) or (None, None)
    hair = choose_precision(precision, prepared, scene, bodies=solid, first=previous is None)
    began, cut = (time.frame - 1) * time.dt, time.frame in cuts
    frame = Frame(leads, surface or (), parts or (), began, time.dt, cut)
    state = next_state(hair, previous, frame, scene)
    return Hair(strands_of(hair, state), state)
