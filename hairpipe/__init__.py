"""A node pipeline for hair: graph file in, USD curves and OpenVDB level sets out.

    shot = hairpipe.load("demo", set={"groom.strands": 500})
    shot.plan(frames="1-12")
    shot.run(frames="1-12", to="hair")
    shot.get("hair@12").points

`load` reads and checks a graph and returns a `Shot`; `Cache` looks after a folder of results; `node_types` lists what
graphs are made of. Input that a person can mend raises `BadInput`. Nothing else is imported before it is used.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hairpipe.app.api.cache import Cache
    from hairpipe.app.api.node_types import node_types
    from hairpipe.app.api.shot import Shot, load
    from hairpipe.errors import BadInput

__version__ = "0.2.0"
__all__ = ["BadInput", "Cache", "Shot", "__version__", "load", "node_types"]

_HOMES = {
    "BadInput": "hairpipe.errors",
    "Cache": "hairpipe.app.api.cache",
    "Shot": "hairpipe.app.api.shot",
    "load": "hairpipe.app.api.shot",
    "node_types": "hairpipe.app.api.node_types",
}
"""Modules that define the names above."""


def __getattr__(name: str) -> Any:
    """Import a name when it is used first."""
    if name not in _HOMES:
        raise AttributeError(f"module 'hairpipe' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    """List the names that notebooks complete."""
    return __all__
