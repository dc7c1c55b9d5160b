"""A picture of strands over time."""

from typing import Annotated, Literal

from hairpipe.engine import File, Frames, Time, Workspace, node
from hairpipe.units import Interval, Metres, Pixels, Suffixes
from hairpipe.values import Strands


@node(frames="once")
def plot_strand(
    hair: tuple[Frames[Strands], ...],
    time: Time,
    workspace: Workspace,
    *,
    poses: Annotated[int, Interval(ge=1, le=1000)] = 8,
    moments: tuple[int, ...] = (),
    strands: tuple[int, ...] = (),
    plane: Literal["xy", "zy", "xz"] = "xy",
    apart: tuple[Metres, Metres] = (0.0, 0.0),
    cases: tuple[str, ...] = (),
    title: str = "",
    width: Annotated[Pixels, Interval(ge=200, le=8000)] = 1200,
    height: Annotated[Pixels, Interval(ge=200, le=8000)] = 750,
) -> Annotated[File, Suffixes((".png",))]:
    """Draw poses of strands at several frames as PNG, coloured by time, with one panel per simulation.

    poses    number of poses, at equal intervals over all frames
    moments  frames to draw instead of `poses`, if the run has any of them
    strands  indices of the strands to draw; empty: all
    plane    coordinates on the horizontal and vertical axis of the picture
    apart    offset of each pose from the previous one, to the right and up
    cases    names of the simulations, in order
    title    text above the picture
    width    width of the picture
    height   height of the picture
    """
    from hairpipe.graphs.experiments.chart.poses import draw_poses, panels_of

    panels = panels_of(hair, time.fps, poses, moments, strands, cases)
    draw_poses(workspace / "poses.png", panels, plane, apart, title, (width, height))
    return File(workspace / "poses.png")
