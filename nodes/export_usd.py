"""The shot as USD."""

from typing import Annotated, Literal

from hairpipe.engine import Cuts, File, Frames, Origin, Time, Workspace, node
from hairpipe.units import Interval, Suffixes
from hairpipe.values import Groom, Guidance, Mesh, Strands
from hairpipe.values.hair import HairState


@node(frames="once")
def export_usd(
    hair: Frames[Strands],
    body: Frames[Mesh] | None,
    groom: Groom | None,
    volume: Frames[File] | None,
    keys: Groom | None,
    states: Frames[HairState] | None,
    guidance: Guidance | None,
    time: Time,
    cuts: Cuts,
    workspace: Workspace,
    origin: Origin = Origin(),  # noqa: B008 - immutable
    *,
    layout: Literal["single", "clips"] = "single",
    curve: Literal["catmull_rom", "bspline"] = "catmull_rom",
    hairs: Annotated[int, Interval(ge=1)] | None = None,
    name: str = "shot",
) -> Annotated[File, Suffixes((".usd", ".usdc"))]:
    """Write hair as smooth curves and the body as a mesh, with velocities, to USD.

    With the key groom of `interpolate_hair` as `keys`, `primvars:groom_guide` is 1 for simulated strands and 0 for
    interpolated ones. Clients that read it may treat the former as guides and not draw them.

    With the `guidance` of `choose_guides`, `hair` is that of the keys. The file has all strands of the groom once, at
    rest, with the guides and weights by which a reader deforms them at every frame (docs/howto/guides.md).

    With the states of hair in locks, `primvars:lockId` is at every frame the `hairId` of a strand's guide, or its own
    if it is simulated.

    With the files of `export_vdb` as `volume`, the stage has a Volume, in a folder next to the file.

    The metadata of the root prim have the version of hairpipe, and the nodes and settings behind the file, from which
    `usd check` names the cause of a finding.

    layout  file layout: a single file, or one file per frame, joined by the first as value clips
    curve   curve basis: catmull_rom through the points of the hair, or bspline with the points as its control polygon,
            whose distance from the points `usd check` reports
    hairs   number of hairs that the strands represent: they are drawn hairs / strands times as wide, narrowing to
            their tips, and `primvars:hairDiameter` has their diameters; if absent, widths are diameters
    name    name of the root prim and of the folders of clips and level sets; shots in one folder need different names
    """
    from hairpipe.errors import BadInput
    from hairpipe.formats.usd.shot import Followers, Shot, VolumeFile, noted, write_clips, write_shot
    from hairpipe.formats.vdb import box
    from hairpipe.groom.key_weights import keys_among, places_of

    vdb = {} if volume is None else {frame: volume[frame].path for frame in volume.numbers}
    files = None if volume is None else {frame: VolumeFile(path, box(path)) for frame, path in vdb.items()}
    if keys is not None and groom is None:
        raise BadInput("keys without the groom", right="in.groom: that of all hair")
    followers = None
    if guidance is not None:
        if keys is None or groom is None or body is None:
            raise BadInput("guidance without keys, groom and body", right="in.keys, in.groom and in.body")
        followers = Followers(groom, keys, places_of(guidance, keys, groom), guidance.weights, guidance.rest)
        groom = keys
        keys = None
    simulated = None if keys is None or groom is None else keys_among(groom, keys) >= 0
    path = workspace / f"{name}.usdc"
    given = (states, simulated, curve, cuts, hairs, noted(**vars(origin)), followers)
    shot = Shot(hair, body, groom, time.fps, name, files, *given)
    return File(path, (write_clips if layout == "clips" else write_shot)(path, shot))
