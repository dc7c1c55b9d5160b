"""Motion of the roots of hair, in numbers."""

from hairpipe.engine import Cuts, Frames, Time, node
from hairpipe.errors import BadInput
from hairpipe.values import Ends, Groom, Mesh, Table


@node(frames="once")
def measure_roots(groom: Groom, body: Frames[Mesh] | None, ends: Frames[Ends] | None, time: Time, cuts: Cuts) -> Table:
    """Measure speed and acceleration of roots on the body or on driven ends, at every frame."""
    from hairpipe.measure.motion import measure_root_motion
    from hairpipe.solve.boundary import driver_of

    drivers = driver_of(body, ends)
    if drivers is None:
        raise BadInput("nothing moves the roots", where="in", right='in.body = "node", or in.ends')
    return measure_root_motion(groom, drivers, time.fps, cuts)
