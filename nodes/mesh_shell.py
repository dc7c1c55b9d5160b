"""The surface of hair."""

from typing import Annotated

from hairpipe.data import Density, Mesh
from hairpipe.graph import node
from hairpipe.units import Interval


@node(frames="each")
def mesh_shell(
    density: Density,
    *,
    blur: Annotated[float, Interval(ge=0.0, le=10.0)] = 2.0,
    level: Annotated[float, Interval(gt=0.0, le=10.0)] = 0.2,
) -> Mesh:
    """The hair shell, closed, as a mesh that moves with the hair; `bake_levelset` gives its signed distance.

    blur   standard deviation of the blur before, in cells; the fewer hairs, the more of it and the wider cells
    level  density at which the shell lies, over the median of what hair has around it
    """
    from hairpipe.volume.shell import shell_of

    return shell_of(density, blur, level)
