"""A picture of a body between two frames."""

from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Fraction, Interval, Metres, MinLen, Pixels, Suffixes, Voxels


@node(frames="once")
def plot_interpolation(
    workspace: Workspace,
    *,
    case: str,
    fractions: Annotated[tuple[Fraction, ...], MinLen(1)] = (0.0, 0.25, 0.5, 0.75, 1.0),
    voxel: Annotated[Metres, Interval(ge=0.01, le=0.2)] = 0.05,
    half_width: Annotated[Voxels, Interval(ge=2.0, le=64.0)] = 8.0,
    title: str = "",
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 1800,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 1200,
) -> Annotated[File, Suffixes((".png",))]:
    """Draw sections through a moving body as PNG, with one row per method of interpolation between frames.

    case        name of the moving body, one of those of measure_interpolation
    fractions   times after the first frame, in frames, one per column
    voxel       sample spacing of the grid; the bodies are about 0.6 m large
    half_width  half width of the narrow band
    title       text above the picture
    width       width of the picture
    height      height of the picture
    """
    from hairpipe.graphs.experiments.chart.sections import draw_sections
    from hairpipe.graphs.experiments.studies.interpolation.sections import sections

    path = workspace / "sections.png"
    found = sections(case, fractions, voxel, half_width)
    rows = {name.replace("_", "-"): panels for name, panels in found.shown.items()}
    columns = [f"{a:g} frames" for a in fractions]
    draw_sections(
        path, rows, found.truth, columns, found.extent, reach=voxel * half_width, title=title, size=(width, height)
    )
    return File(path)
