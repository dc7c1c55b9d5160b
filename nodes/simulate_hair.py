"""The hair simulation: every strand of the groom, carried by the body."""

from typing import Annotated, NamedTuple

from hairpipe.data import Groom, LevelSet, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.graph import Pair, Time, node
from hairpipe.sim.material import Material
from hairpipe.sim.scene import Air, BodyContact, Scene, StepControl, StrainLimit
from hairpipe.units import Interval, MetresPerSecondSquared


class Hair(NamedTuple):
    """Strands to look at, and the state the next frame starts from."""

    strands: Strands
    state: HairState


@node(frames="scan")
def simulate_hair(
    groom: Groom,
    body: Pair[Mesh],
    surface: Pair[LevelSet] | None,
    previous: HairState | None,
    time: Time,
    *,
    material: Material = Material(),  # noqa: B008 (frozen)
    gravity: Annotated[MetresPerSecondSquared, Interval(ge=0.0, le=1000.0)] = 9.81,
    air: Air = Air(),  # noqa: B008
    contact: BodyContact = BodyContact(),  # noqa: B008
    strain: StrainLimit = StrainLimit(),  # noqa: B008
    steps: StepControl = StepControl(),  # noqa: B008
) -> Hair:
    """Mass-spring hair after Selle, Lentine, Fedkiw 2008: every strand a network of springs, solved at once.

    material  of the fibre; the spring constants are calibrated from it
    gravity   along -Y
    air       what slows the hair where nothing touches it
    contact   how it touches the body; without a surface it passes through
    strain    how far a segment may be stretched
    steps     how a frame is cut into steps
    """
    from hairpipe.sim.advance import advance_frame, make_hair, start, strands_of

    hair = make_hair(groom, material)
    scene = Scene(gravity, air, contact, strain, steps)
    if previous is None:
        state = start(hair, body.current, scene)
    else:
        state = advance_frame(hair, previous, body, surface, time.dt, scene)
    return Hair(strands_of(hair, state), state)
