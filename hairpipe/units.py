"""Units of settings: plain annotations, so that physics and nodes declare a field once, without the engine.

A setting is `voxel: Annotated[Metres, Gt(0)] = 0.005`: its unit and range stand in the annotation and are read
by the engine for validation and by `hairpipe nodes` for documentation. Values are SI; nothing is converted.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Gt, Interval, Le, Lt, MinLen

__all__ = [
    "Calls",
    "Degrees",
    "DegreesPerSecond",
    "Fraction",
    "Ge",
    "Gt",
    "Hertz",
    "Interval",
    "KilogramsPerCubicMetre",
    "Le",
    "Lt",
    "Metres",
    "MetresPerSecond",
    "MetresPerSecondSquared",
    "MetresSquaredPerSecondSquared",
    "MinLen",
    "Newtons",
    "NewtonsPerMetre",
    "PascalSeconds",
    "Pascals",
    "PerSecond",
    "Pixels",
    "Reads",
    "Replaces",
    "Seconds",
    "SecondsSquaredPerMetreSquared",
    "Suffixes",
    "Unit",
    "Voxels",
]


@dataclass(frozen=True)
class Unit:
    """The unit a number is given in, for messages and documentation."""

    symbol: str


@dataclass(frozen=True)
class Suffixes:
    """The suffixes of files that a setting reads, or that a node writes, in lower case: they name the format."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Reads:
    """The files that are read for a file of a setting, all of which key a result, where it is not that file alone.

    files  returns their paths, by names that do not change when all of them move; BadInput where one is missing
    mark   text in the name of a file that stands for several
    """

    files: Callable[[Path], dict[str, Path]]
    mark: str = "#"


@dataclass(frozen=True)
class Calls:
    """The libraries that one choice of a setting calls, whose versions key its results; others need no import of them.

    libraries  names of their modules
    """

    choice: str
    libraries: tuple[str, ...]


@dataclass(frozen=True)
class Replaces:
    """Former settings in place of a setting, each with what to write now, for the message that refuses them."""

    former: tuple[tuple[str, str], ...]


Metres = Annotated[float, Unit("m")]
Seconds = Annotated[float, Unit("s")]
SecondsSquaredPerMetreSquared = Annotated[float, Unit("s^2/m^2")]
PerSecond = Annotated[float, Unit("1/s")]
Hertz = Annotated[float, Unit("Hz")]
MetresPerSecond = Annotated[float, Unit("m/s")]
MetresPerSecondSquared = Annotated[float, Unit("m/s^2")]
MetresSquaredPerSecondSquared = Annotated[float, Unit("m^2/s^2")]
Degrees = Annotated[float, Unit("deg")]
DegreesPerSecond = Annotated[float, Unit("deg/s")]
Newtons = Annotated[float, Unit("N")]
NewtonsPerMetre = Annotated[float, Unit("N/m")]
Pascals = Annotated[float, Unit("Pa")]
PascalSeconds = Annotated[float, Unit("Pa s")]
KilogramsPerCubicMetre = Annotated[float, Unit("kg/m^3")]
Voxels = Annotated[float, Unit("voxels")]
Pixels = Annotated[int, Unit("px")]
Fraction = Annotated[float, Unit("1"), Interval(ge=0.0, le=1.0)]
