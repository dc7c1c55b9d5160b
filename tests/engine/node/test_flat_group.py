"""A group whose fields are settings of the node itself."""

from dataclasses import dataclass
from typing import Annotated

from hairpipe.engine import flat_group, node
from hairpipe.engine.node.settings import build_settings, check_settings, fields_of
from hairpipe.units import Ge
from hairpipe.values import Table


@dataclass(frozen=True)
class Water:
    """What is sounded.

    depth  of the water
    """

    depth: Annotated[float, Ge(0.0)] = 2.0


@dataclass(frozen=True)
class Shared(Water):
    """What two nodes have in common.

    name  of the lake
    """

    name: str = "Bourget"


@node(frames="once")
@flat_group("shared")
def sound(*, shared: Shared, wide: int = 1) -> Table:
    """Sound a lake.

    wide  of the boat
    """
    return shared, wide  # type: ignore[return-value]


def test_its_fields_are_settings_with_their_help_and_the_function_gets_the_group():
    node_type = sound.__node__
    helps = {"depth": "of the water", "name": "of the lake", "wide": "of the boat"}
    assert {field.name: field.help for field in fields_of(node_type)} == helps
    plain = check_settings(node_type, {"depth": 5}, ".".join)
    assert sound(**build_settings(node_type, plain)) == (Shared(5.0), 1)
