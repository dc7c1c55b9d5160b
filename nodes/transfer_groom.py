"""A groom of one head on another."""

from typing import Literal

from hairpipe.engine import node
from hairpipe.units import Metres
from hairpipe.values import Body, Groom

Landmark = tuple[Metres, Metres, Metres, Metres, Metres, Metres]


@node(frames="once")
def transfer_groom(
    groom: Groom,
    source: Body,
    target: Body,
    *,
    by: Literal["vertices", "uv", "surface"] = "surface",
    landmarks: tuple[Landmark, ...] = (),
    lengths: Literal["kept", "scaled"] = "kept",
) -> Groom:
    """Transfer a groom from the head on which it grows to another: roots on the new skin, strands outside of it.

    Segments next to the skin turn with it, those far from it with the head on average; strands that would enter the new
    head are turned out of it. Ids, order, groups, guides, colours, widths and maps are kept.

    by         method by which places of the heads correspond: vertices (meshes of the same triangles), uv (equal
               texture coordinates) or surface (the nearest place once the heads are aligned)
    landmarks  positions of a place on the source and on the target, x, y, z each, for every pair that aligns the heads;
               by default the extents of their maps "scalp" do, or of their meshes if neither has the map
    lengths    lengths of strands: kept, or scaled by the ratio of the heads
    """
    from hairpipe.groom.transferring import transferred

    return transferred(groom, source, target, by, lengths, landmarks)
