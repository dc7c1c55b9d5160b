"""A picture of sections through hair density."""

from typing import Annotated, Literal

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Interval, Metres, Pixels, Suffixes
from hairpipe.values import Density


@node(frames="each")
def plot_section(
    densities: tuple[Density, ...],
    workspace: Workspace,
    *,
    axis: Literal["x", "y", "z"] = "x",
    place: Annotated[Metres, Interval(ge=-1e3, le=1e3)] = 0.0,
    names: tuple[str, ...] = (),
    title: str = "",
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 1200,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 600,
) -> Annotated[File, Suffixes((".png",))]:
    """Draw sections through densities of hair side by side as PNG, with one colour scale.

    axis    axis normal to the section
    place   coordinate of the section along the axis
    names   names of the densities, in order
    title   text above the picture
    width   width of the picture
    height  height of the picture
    """
    from hairpipe.errors import BadInput
    from hairpipe.graphs.experiments.chart.densities import draw_densities
    from hairpipe.graphs.experiments.chart.sections import section_of

    if names and len(names) != len(densities):
        raise BadInput(f"{len(names)} names for {len(densities)} densities", where="names", right="one each, or none")
    path = workspace / "section.png"
    across = "xyz".index(axis)
    cut = f"{axis} = {place:g} m"
    panels = [
        (name or cut, *section_of(density, across, place))
        for name, density in zip(names or [""] * len(densities), densities, strict=True)
    ]
    draw_densities(path, panels, title=title or cut, size=(width, height))
    return File(path)
