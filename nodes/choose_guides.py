"""Guides chosen by the error of the hair that follows them."""

from typing import Annotated, Literal, NamedTuple

from hairpipe.engine import Frames, node
from hairpipe.units import Ge, Gt, Interval, Metres
from hairpipe.values import Ends, Groom, Guidance, Mesh, Strands, Table


class Guides(NamedTuple):
    """Strands that are guides, what all strands follow, and the error of that."""

    keys: Groom
    guidance: Guidance
    bound: Table


@node(frames="once")
def choose_guides(
    groom: Groom,
    hair: Frames[Strands],
    body: Frames[Mesh] | None,
    ends: Frames[Ends] | None,
    twins: tuple[Frames[Strands], ...] | None,
    keys: Groom | None,
    key_hair: Frames[Strands] | None,
    *,
    guides: Annotated[int, Ge(1)] | None = None,
    tolerance: Annotated[Metres, Gt(0.0)] | None = None,
    by: Literal["motion", "roots"] = "motion",
    samples: Annotated[int, Interval(ge=1, le=1000)] = 16,
) -> Guides:
    """Choose guides from which `interpolate_hair` computes the hair of a full simulation with the least error.

    `in.hair` is the full simulation, of which sampled frames are read. Every strand has up to three guides, their
    weights, and a rest shape that they rotate, fitted to these frames (`guidance`). `bound` has the errors at the
    sampled frames, and at as many frames between them that nothing was fitted to: of strands, root mean square over
    their points and frames. The floor is the part that is chance, from the `twins`: other members of the ensemble of
    `perturb_groom`, simulated like `in.hair`. Contact of interpolated hair with bodies is not part of it.

    With `keys` these strands are the guides, and only the guidance is fitted; `key_hair` is their hair if it was
    simulated alone. Memory: 100 bytes for each point of the groom and sample.

    guides     number of guides; if absent, the fewest that keep the tolerance
    tolerance  maximum error of 95 % of the strands, above the floor, in place of the number of guides
    by         order of choice: motion (least error of the strands that follow) or roots (farthest from each other)
    samples    number of frames to which guidance is fitted, evenly over the shot after its first frame
    """
    from hairpipe.errors import BadInput
    from hairpipe.measure.following import Guiding, Sample
    from hairpipe.solve.boundary import driver_of, motion_of_roots

    def read(frame: int) -> Sample:
        driver = driver_of(*(None if some is None else some[frame] for some in (body, ends)))
        others = [twin[frame] for twin in twins or ()]
        alone = None if key_hair is None else key_hair[frame]
        return Sample(hair[frame], motion_of_roots(driver, groom), others, alone)

    if keys is not None and (guides is not None or tolerance is not None):
        raise BadInput("guides are given, and not chosen", where="in.keys", right="without guides and tolerance")
    if key_hair is not None and keys is None:
        raise BadInput("hair of keys without these", where="in.key_hair", right="in.keys")
    found = Guiding(groom, read, hair.numbers, samples)
    return Guides(*(found.find(guides, tolerance, by) if keys is None else found.fit(keys)[0]))
