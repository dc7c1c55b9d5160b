"""The strand models: each is a file next to this one, and is named here."""

from typing import TYPE_CHECKING, Literal, get_args

if TYPE_CHECKING:  # a node that reads the names compiles nothing
    from hairpipe.strands.interface import ModelKind

ModelName = Literal["network", "chain", "rod"]


def strand_models() -> dict[str, "ModelKind"]:
    """Import the models of the house, and return them by name."""
    from hairpipe.strands.chain import CHAIN
    from hairpipe.strands.network import NETWORK
    from hairpipe.strands.rod import ROD

    models = {kind.name: kind for kind in (NETWORK, CHAIN, ROD)}
    assert tuple(models) == get_args(ModelName)
    return models
