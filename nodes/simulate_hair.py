"""The hair simulation: every strand of the groom, carried by the body or by its ends."""

from typing import Annotated, Literal, NamedTuple

from hairpipe.data import Ends, Groom, LevelSet, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.graph import Pair, Time, node
from hairpipe.sim.material import Material
from hairpipe.sim.models.construction import Construction
from hairpipe.sim.scene import Air, BodyContact, SagFree, Scene, Scheme, StepControl, StrainLimit
from hairpipe.units import Interval, MetresPerSecondSquared


class Hair(NamedTuple):
    """Strands to look at, and the state the next frame starts from."""

    strands: Strands
    state: HairState


@node(frames="scan")
def simulate_hair(
    groom: Groom,
    body: Pair[Mesh] | None,
    surface: Pair[LevelSet] | None,
    ends: Pair[Ends] | None,
    previous: HairState | None,
    time: Time,
    *,
    model: Literal["network", "chain"] = "network",
    material: Material = Material(),  # noqa: B008 (frozen)
    construction: Construction = Construction(),  # noqa: B008
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
    air: Air = Air(),  # noqa: B008
    contact: BodyContact = BodyContact(),  # noqa: B008
    strain: StrainLimit | None = None,
    steps: StepControl = StepControl(),  # noqa: B008
    scheme: Scheme = Scheme(),  # noqa: B008
    sag_free: SagFree | None = None,
) -> Hair:
    """Mass-spring hair after Selle, Lentine, Fedkiw 2008: every strand a network of springs, solved at once.

    model         network: as published; chain: straight hair without twist, at half the particles
    material      of the fibre; the spring constants are calibrated from it
    construction  of the network, to take apart what it consists of
    gravity       along -Y
    air           what slows the hair where nothing touches it
    contact       how it touches the body; without a surface it passes through
    strain        how far a segment may be stretched; without, as far as its springs let it
    steps         how a frame is cut into steps
    scheme        how a step is computed
    sag_free      start at rest as groomed; without, springs rest in the groom's shape and hair sags from it
    """
    from hairpipe.sim.advance import advance_frame, leads_of, make_hair, start, strands_of

    hair = make_hair(groom, material, model, construction)
    scene = Scene(gravity, air, contact, strain, steps, scheme, sag_free)
    leads = leads_of(body, ends)
    state = advance_frame(hair, previous, leads, surface, time.dt, scene) if previous else start(hair, leads[1], scene)
    return Hair(strands_of(hair, state), state)
