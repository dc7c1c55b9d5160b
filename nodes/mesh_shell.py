"""The surface of hair."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Interval
from hairpipe.values import Density, Mesh


@node(frames="each")
def mesh_shell(
    density: Density,
    *,
    blur: Annotated[float, Interval(ge=0.0, le=10.0)] = 2.0,
    level: Annotated[float, Interval(gt=0.0, le=10.0)] = 0.2,
) -> Mesh:
    """Extract the closed shell of hair as a mesh that moves with the hair, for `bake_levelset`.

    blur   standard deviation of the preceding blur, in cells; sparse hair needs more blur and larger cells
    level  density of the shell, relative to the median density around hair
    """
    from hairpipe.volume.density import shell_of

    return shell_of(density, blur, level)
