"""The shot as USD."""

from typing import Annotated, Literal

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.data.hair import HairState
from hairpipe.graph import Cuts, File, Frames, Time, Workspace, node
from hairpipe.units import Suffixes


@node(frames="once")
def export_usd(
    hair: Frames[Strands],
    body: Frames[Mesh] | None,
    groom: Groom | None,
    volume: Frames[File] | None,
    keys: Groom | None,
    states: Frames[HairState] | None,
    time: Time,
    cuts: Cuts,
    workspace: Workspace,
    *,
    layout: Literal["single", "clips"] = "single",
    curve: Literal["catmull_rom", "bspline"] = "catmull_rom",
    name: str = "shot",
) -> Annotated[File, Suffixes((".usd", ".usdc"))]:
    """USD of the hair as smooth curves and of the body as a mesh, with velocities, at every frame.

    The groom of the keys of `interpolate_hair` marks the hairs that are simulated: `primvars:groom_guide` is 1 for them
    and 0 for those that are interpolated. Clients that read it may take the former for guides, and not draw them.

    Of hair in locks, given the states of its simulation, `primvars:lockId` is at every frame the `hairId` of the hair
    that each follows, and its own where it is simulated.

    The files of `export_vdb`, given as `volume`, become a Volume, in a folder next to the file.

    layout  one file, or one file a frame that the first one joins as value clips
    curve   Catmull-Rom, through the points of the hair; or a B-spline whose control hull they are, from root to tip, of
            which `usd check` says that it misses them
    name    of the root prim, and of the folders of clips and of level sets: give two shots in one place two names
    """
    from hairpipe.errors import BadInput
    from hairpipe.groom.keys.key_weights import keys_among
    from hairpipe.io.usd.shot import Shot, write_clips, write_shot
    from hairpipe.io.usd.volume import VolumeFile
    from hairpipe.levelset.vdb_header import box

    vdb = {} if volume is None else {frame: volume[frame].path for frame in volume.numbers}
    files = None if volume is None else {frame: VolumeFile(path, box(path)) for frame, path in vdb.items()}
    if keys is not None and groom is None:
        raise BadInput("keys without the groom", right="in.groom: that of all hair")
    simulated = None if keys is None or groom is None else keys_among(groom, keys) >= 0
    path = workspace / f"{name}.usdc"
    shot = Shot(hair, body, groom, time.fps, name, files, states, simulated, curve, cuts)
    return File(path, (write_clips if layout == "clips" else write_shot)(path, shot))
