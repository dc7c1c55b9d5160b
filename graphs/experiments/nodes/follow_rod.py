"""Rod theory in the columns of a simulation."""

from typing import Annotated

from hairpipe.engine import Frames, Time, node
from hairpipe.strands.material import Material
from hairpipe.units import Ge
from hairpipe.values import Ends, Groom, Table


@node(frames="once")
def follow_rod(
    groom: Groom,
    ends: Frames[Ends],
    time: Time,
    *,
    material: Material = Material(),  # noqa: B008 (frozen)
    every: Annotated[int, Ge(1)] = 1,
) -> Table:
    """Tabulate an ideal quasi-static weightless rod with the ends of strand 0, in the columns of measure_strands.

    Equilibria of Kirchhoff's equations are followed from frame to frame, until there is none nearby: there a strand
    snaps.

    material  material of the fibre, as in simulate_hair; the rod is inextensible
    every     number of frames from one row to the next
    """
    from hairpipe.graphs.experiments.studies.theory.driven_rods import driven_rod

    seen = Frames(ends.numbers[::every], ends.__getitem__)
    return driven_rod(groom, seen, time.fps, material.bending, material.torsion)
