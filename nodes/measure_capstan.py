"""What friction holds around a cylinder, as numbers."""

from typing import Annotated

from hairpipe.data import Table
from hairpipe.graph import node
from hairpipe.units import Ge


@node(frames="once")
def measure_capstan(tension: Table, *, friction: Annotated[float, Ge(0.0)] = 0.3) -> Table:
    """The ratio of tensions before and behind a cylinder, and the greatest that friction can hold.

    friction  Coulomb coefficient
    """
    from hairpipe.measure.capstan import measure_ratios

    return measure_ratios(tension, friction)
