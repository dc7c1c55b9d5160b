"""Settings that are painted on a body, or vary from strand to strand and along strands, and their values there.

Tiles of an image are those of the UDIM convention: `name.<UDIM>.png` stands for `name.1001.png` and so on; the tile at
texture coordinates (u, v) has the number 1001 + floor(u) + 10 floor(v), floor(u) < 10.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, get_type_hints
from warnings import warn

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.units import Degrees, Fraction, Ge, Gt, Interval, Metres, Reads
from hairpipe.values import Body, Groom
from hairpipe.values.groom import fractions_along, labels_of
from hairpipe.values.random_streams import chances, stream
from hairpipe.values.strand_arrays import members_of, name_strands
from hairpipe.values.triangles import Sites, blend_corners, site_uv

MARK = "<UDIM>"
FIRST = 1001
COLUMNS = 10
EDGE = 1e-5  # width of the left and lower edge of a tile that counts as the neighbour where there is no such tile


def list_tiles(path: Path) -> dict[str, Path]:
    """Return the files of an image by the numbers of the tiles; one alone has none. BadInput where there are none."""
    before, mark, after = path.name.partition(MARK)
    if not mark:
        return {"": path}
    form = re.compile(rf"{re.escape(before)}([1-9]\d{{3}}){re.escape(after)}")
    try:
        names = sorted(file.name for file in path.parent.iterdir())
    except OSError:
        names = []
    found = {match[1]: path.with_name(name) for name in names if (match := form.fullmatch(name))}
    if not found:
        raise BadInput("there are no tiles", where=path, right=path.name.replace(MARK, str(FIRST)))
    return found


Image = Annotated[Path, Reads(list_tiles, MARK)]
"""A picture, or its tiles."""


@dataclass(frozen=True)
class Paint:
    """Values 0..1 painted on the body, as a vertex map or as an image over its texture coordinates.

    map    name of a vertex map of the body
    image  path of an image file, or of tiles, name.<UDIM>.png: black is 0, white is 1
    """

    map: str | None = None
    image: Image | None = None


@dataclass(frozen=True)
class Painted:
    """A number per strand, given as a plain number or as a table.

    value      value at a paint of 1, or everywhere without paint
    low        value at a paint of 0
    variation  relative variation: each strand has a random factor in [1 - variation, 1 + variation]
    map        name of a vertex map of the body that scales the value
    image      path of an image file, or of tiles, name.<UDIM>.png, that scales the value: black is 0, white is 1
    """

    value: float
    low: float = 0.0
    variation: Fraction = 0.0
    map: str | None = None
    image: Image | None = None


@dataclass(frozen=True)
class PaintedMetres(Painted):
    __doc__ = Painted.__doc__
    value: Annotated[Metres, Gt(0.0)]
    low: Annotated[Metres, Ge(0.0)] = 0.0


@dataclass(frozen=True)
class PaintedDegrees(Painted):
    __doc__ = Painted.__doc__
    value: Annotated[Degrees, Interval(ge=0.0, le=90.0)]
    low: Annotated[Degrees, Interval(ge=0.0, le=90.0)] = 0.0


Factor = Annotated[float, Ge(0.0)]
Profile = tuple[tuple[Fraction, Factor], ...]
"""Fractions of the length of a strand from the root, ascending, each with its factor; linear between them."""


@dataclass(frozen=True)
class Varied(Painted):
    """A number that varies from strand to strand and along strands, given as a plain number or as a table.

    value      value at a map of 1, or everywhere without map
    low        value at a map of 0
    variation  relative variation: each strand has a random factor in [1 - variation, 1 + variation]
    map        name of a map of the groom that scales the value: a vertex map of its scalp, a primvar of its file, or a
               group, which is 1 on its strands and 0 on others
    image      path of an image file, or of tiles, name.<UDIM>.png, over the texture coordinates of roots, that scales
               the value: black is 0, white is 1
    profile    factors along a strand: fractions of the length from the root, ascending, each with its factor, linear
               between them, and equal beyond the first and last; by default 1
    groups     factors of groups of the groom, each ["name", factor]; 1 for others
    """

    profile: Profile = ()
    groups: tuple[tuple[str, Factor], ...] = ()

    @property
    def is_constant(self) -> bool:
        """Whether the setting is its value everywhere."""
        return self == type(self)(self.value)


@dataclass(frozen=True)
class VariedWidth(Varied):
    """A width of strands; the widths that the groom carries can take the place of its value.

    widths  factor on the widths of the groom, which then take the place of `value`; by default they are not used
    """

    widths: Factor | None = None


ReadImage = Callable[[Path], np.ndarray]
"""Returns the image in a file, (height, width) float64 in 0..1, the top row first."""
Coat = Callable[[Sites], np.ndarray]  # paint as a function: sites (k,) to values 0..1, (k,)


def tiles_at(uv: np.ndarray, known: set[int], where: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of the tile at texture coordinates (k, 2), (k,), and the coordinates in that tile, (k, 2).

    known  numbers of the tiles that there are

    Raises BadInput naming the tile that is missing, or coordinates without a tile.
    """
    cells = np.floor(uv)
    numbers = _numbers(cells)
    on_edge = uv - cells < EDGE
    for axes in ([0], [1], [0, 1]):
        lacking = ~np.isin(numbers, list(known)) & on_edge[:, axes].all(axis=1)
        back = np.floor(uv)
        back[:, axes] -= 1.0
        better = lacking & np.isin(_numbers(back), list(known))
        cells[better] = back[better]
        numbers = _numbers(cells)
    wrong = (cells < 0.0).any(axis=1) | (cells[:, 0] >= COLUMNS)
    if wrong.any():
        u, v = uv[wrong][0]
        what = f"texture coordinates ({u:.3g}, {v:.3g}) of a root are in no tile"
        raise BadInput(what, where=where, right=f"0 to {COLUMNS} along u, 0 or more along v")
    missing = ~np.isin(numbers, list(known))
    if missing.any():
        what = f"tile {numbers[missing].min()} is missing, with {np.count_nonzero(missing)} roots"
        raise BadInput(what, where=where, right=f"a file of that number, next to {min(known)}")
    return numbers, uv - cells


def _numbers(cells: np.ndarray) -> np.ndarray:
    return (FIRST + cells[:, 0] + COLUMNS * cells[:, 1]).astype(int)


@dataclass(frozen=True)
class Canvas:
    """A body with the sources of its paint and random numbers.

    read_image  reads the images of settings
    seed        seed of all random numbers
    """

    body: Body
    read_image: ReadImage
    seed: int

    def coat(self, paint: Paint | Painted, name: str) -> Coat | None:
        """Return the paint of a setting, or None where there is none; BadInput where the body cannot carry it."""
        if paint.map is not None and paint.image is not None:
            raise BadInput("both a map and an image are given", where=name, right="one of the two")
        if paint.map is not None:
            return vertex_coat(self.body, paint.map, name)
        if paint.image is None:
            return None
        image = paint.image
        mesh = self.body.mesh
        if mesh.uv is None:
            raise BadInput("the body has no texture coordinates for an image", where=name, right="a vertex map")
        read = cache(self.read_image)
        read(
            next(iter(list_tiles(image).values()))
        )  # a file that cannot be read is named where nothing is painted, too
        return lambda sites: sample_image(image, read, site_uv(mesh, sites), name)

    def numbers(self, setting: Painted, name: str, sites: Sites) -> np.ndarray:
        """Return the value of a setting for the strand at every site, (k,)."""
        coat = self.coat(setting, name)
        values = setting.value if coat is None else setting.low + (setting.value - setting.low) * coat(sites)
        chance = stream(self.seed, name).uniform(-1.0, 1.0, len(sites.triangles))
        return values * (1.0 + setting.variation * chance)


def vertex_coat(body: Body, map_name: str, where: str) -> Coat:
    """Return the paint of a vertex map, linear in every triangle."""
    if map_name not in body.maps:
        known = ", ".join(f"'{name}'" for name in sorted(body.maps)) or "none"
        raise BadInput(f"the body has no map '{map_name}'", where=where, right=f"its maps: {known}")
    corners = body.maps[map_name][body.mesh.triangles]
    return lambda sites: blend_corners(corners[sites.triangles], sites)


def maps_at(body: Body, sites: Sites) -> dict[str, np.ndarray]:
    """Return the vertex maps of a body at sites, by name, (k,) each; pure."""
    return {name: vertex_coat(body, name, name)(sites) for name in body.maps}


def sample_image(image: Path, read_image: ReadImage, uv: np.ndarray, where: str) -> np.ndarray:
    """Return an image, or its tiles, at texture coordinates (k, 2), (k,); warn where a single picture ends."""
    tiles = list_tiles(image)
    if "" in tiles:
        if (np.abs(uv - 0.5) > 0.5 + EDGE).any():
            message = f"{where}: roots with texture coordinates outside 0..1 take the border of {image.name}"
            warn(f"{message} (name.{MARK}.png reads tiles)", stacklevel=2)
        return sample_picture(read_image(image), uv)
    files = {int(number): file for number, file in tiles.items()}
    numbers, inside = tiles_at(uv, set(files), where)
    values = np.empty(len(uv))
    for number in np.unique(numbers).tolist():
        here = numbers == number
        values[here] = sample_picture(read_image(files[number]), inside[here])
    return values


def sample_picture(picture: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return a picture, (height, width), bilinearly at texture coordinates (k, 2), (0, 0) its bottom left corner."""
    height, width = picture.shape
    x = np.clip(uv[:, 0] * width - 0.5, 0.0, width - 1.0)
    y = np.clip((1.0 - uv[:, 1]) * height - 0.5, 0.0, height - 1.0)
    i = x.astype(int)
    j = y.astype(int)
    right, below = np.minimum(i + 1, width - 1), np.minimum(j + 1, height - 1)
    top = picture[j, i] + (x - i) * (picture[j, right] - picture[j, i])
    bottom = picture[below, i] + (x - i) * (picture[below, right] - picture[below, i])
    return top + (y - j) * (bottom - top)


def values_of(setting: Varied | float, groom: Groom, name: str, read_image: ReadImage | None = None) -> Any:
    """Return the number that a setting is everywhere, or its values at points and on the segments after them, (2, P).

    name  of the setting, for messages

    The value on a segment is that at its middle; that after the last point of a strand is of no segment.

    Raises BadInput where the groom does not carry what the setting names, and for values out of range.
    """
    if not isinstance(setting, Varied):
        return setting
    if setting.is_constant:
        return setting.value
    strands = np.repeat(np.arange(len(groom.ids)), np.diff(groom.offsets))
    along = fractions_along(groom.points, groom.offsets)
    along = with_middles(along)
    along[1, groom.offsets[1:] - 1] = 1.0
    values: Any = setting.value
    if isinstance(setting, VariedWidth) and setting.widths is not None:
        if groom.widths is None:
            right = "a number, or a groom of a file with widths"
            raise BadInput("the groom carries no widths", where=name, right=right)
        values = setting.widths * with_middles(groom.widths)
    paint = _paint(setting, groom, name, read_image)
    if paint is not None:
        values = setting.low + (values - setting.low) * paint[strands]
    factors = np.ones(len(groom.ids))
    for group, factor in setting.groups:
        factors *= np.where(members_of(groom, (group,), f"{name}.groups"), factor, 1.0)
    factors *= 1.0 + setting.variation * chances(0, name, groom.ids)
    values = values * factors[strands] * np.ones_like(along)
    if setting.profile:
        places, profile = np.array(setting.profile).T
        if (np.diff(places) <= 0.0).any():
            raise BadInput("fractions that do not ascend", where=f"{name}.profile", right="[[0.0, 1.0], [1.0, 0.2]]")
        values = values * np.interp(along, places, profile)
    _check_range(values, setting, groom.ids[strands], name)
    return values


def with_middles(values: np.ndarray) -> np.ndarray:
    """Return values at points, (P,), and their means with the next ones, (2, P); the last has its own."""
    return np.stack([values, np.append(0.5 * (values[:-1] + values[1:]), values[-1])])


def map_of(groom: Groom, name: str, where: str) -> np.ndarray:
    """Return a map of the groom, or a group as 1 on its strands and 0 elsewhere, (S,); BadInput without."""
    labels = np.empty(0, str) if groom.groups is None else labels_of(groom.groups, groom.group_names)
    found = groom.maps.get(name)
    if found is None and name in labels:
        return members_of(groom, (name,), where).astype(float)
    if found is None:
        known = [*sorted(groom.maps), *np.unique(labels).tolist()]
        right = ", ".join(f"'{each}'" for each in known) or "a groom with maps or groups: this one has none"
        raise BadInput(f"the groom carries no map or group '{name}'", where=where, right=right)
    if found.shape != groom.ids.shape:
        what = f"the map '{name}' of the groom has shape {found.shape}"
        raise BadInput(what, where=where, right=f"a value for each of {len(groom.ids)} strands")
    return found


def _paint(setting: Varied, groom: Groom, name: str, read_image: ReadImage | None) -> np.ndarray | None:
    if setting.map is not None and setting.image is not None:
        raise BadInput("both a map and an image are given", where=name, right="one of the two")
    if setting.map is not None:
        return map_of(groom, setting.map, name)
    if setting.image is None:
        return None
    if read_image is None or not groom.root_uv.any():
        raise BadInput("the roots have no texture coordinates for an image", where=name, right="a map")
    return sample_image(setting.image, read_image, groom.root_uv.astype(float), name)


def _check_range(values: np.ndarray, setting: Varied, ids: np.ndarray, name: str) -> None:
    unit, interval = get_type_hints(type(setting), include_extras=True)["value"].__metadata__
    wrong = ~((values >= interval.ge) & (values <= interval.le))
    if wrong.any():
        worst = values[wrong][0]
        strands = np.unique(ids[wrong.any(axis=0)])
        right = f"{interval.ge:g} to {interval.le:g} {unit.symbol} everywhere, as value, low, profile and maps make it"
        raise BadInput(f"{name} is {worst:.3g} {unit.symbol}: {name_strands(strands)}", where=name, right=right)
