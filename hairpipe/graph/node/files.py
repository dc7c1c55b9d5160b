"""Files as values: what an export hands over, and where it may write it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NewType

Workspace = NewType("Workspace", Path)
"""An empty folder of its own for one evaluation of a node; gone afterwards."""


@dataclass(frozen=True)
class File:
    """A file that a node has written in its workspace; it is stored, and published, by its bytes.

    path        of the file
    companions  files that must lie beside it, by the relative name under which the file refers to them
    """

    path: Path
    companions: Mapping[str, Path] = field(default_factory=dict)
