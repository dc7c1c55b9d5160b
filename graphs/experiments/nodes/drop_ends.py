"""Roots in free fall through still air."""

from typing import Annotated, Literal

from hairpipe.engine import Time, node
from hairpipe.strands.material import Material
from hairpipe.units import Gt, PerSecond
from hairpipe.values import Ends, Groom


@node(frames="each")
def drop_ends(
    groom: Groom,
    time: Time,
    *,
    at: int = 1,
    law: Literal["across", "along", "rate"] = "across",
    rate: Annotated[PerSecond, Gt(0.0)] = 8.0,
    material: Material = Material(),  # noqa: B008 (frozen)
) -> Ends:
    """Move the roots as fibres that fall freely from rest in still air: with them no force acts on the hair.

    at        frame at which the fall begins
    law       force of the air: across a fibre, along it, or of a damping rate
    rate      damping rate of the last of these laws
    material  material of the fibre, as in simulate_hair
    """
    from hairpipe.graphs.experiments.studies.theory.falling import dropped_ends

    return dropped_ends(len(groom.ids), law, (time.frame - at) / time.fps, material, rate)
