"""Rod theory compared with a simulation."""

from typing import Annotated

from hairpipe.data import Ends, Groom, Table
from hairpipe.graph import Frames, Time, node
from hairpipe.sim.material import Material
from hairpipe.units import Ge


@node(frames="once")
def follow_rod(
    groom: Groom,
    ends: Frames[Ends],
    time: Time,
    *,
    material: Material = Material(),  # noqa: B008 (frozen)
    every: Annotated[int, Ge(1)] = 1,
) -> Table:
    """The table of measure_strands for an ideal rod, weightless and slow, whose ends are led as those of strand 0.

    It follows Kirchhoff's equations from frame to frame, until there is no equilibrium nearby: there a hair snaps.

    material  of the fibre, as in simulate_hair; a rod does not stretch
    every     frames from one row to the next
    """
    from hairpipe.graphs.experiments.studies.theory.led_rods import led_rod

    seen = Frames(ends.numbers[::every], ends.__getitem__)
    return led_rod(groom, seen, time.fps, material.bending, material.torsion)
