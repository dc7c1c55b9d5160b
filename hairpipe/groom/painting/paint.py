"""Painted settings: values over the body, and a number for every strand."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from warnings import warn

import numpy as np

from hairpipe.data import Body
from hairpipe.errors import BadInput
from hairpipe.groom.painting.painted import Paint, Painted
from hairpipe.groom.painting.tiles import EDGE, MARK, list_tiles, tiles_at
from hairpipe.groom.random_streams import stream
from hairpipe.spatial.triangles import Sites, blend_corners, site_uv

Coat = Callable[[Sites], np.ndarray]
"""Paint as a function: sites (k,) to values 0..1, (k,)."""
ReadImage = Callable[[Path], np.ndarray]
"""Returns the image in a file, (height, width) float64 in 0..1, the top row first."""


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
        if paint.image is not None:
            return image_coat(self.body, paint.image, self.read_image, name)
        return None

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


def image_coat(body: Body, image: Path, read_image: ReadImage, where: str) -> Coat:
    """Return the paint of an image laid over the texture coordinates of the body."""
    if body.mesh.uv is None:
        raise BadInput("the body has no texture coordinates for an image", where=where, right="a vertex map")
    read = cache(read_image)
    read(next(iter(list_tiles(image).values())))  # a file that cannot be read is named where nothing is painted, too
    return lambda sites: sample_image(image, read, site_uv(body.mesh, sites), where)


def sample_image(image: Path, read_image: ReadImage, uv: np.ndarray, where: str) -> np.ndarray:
    """Return an image, or its tiles, at texture coordinates (k, 2), (k,).

    Warns of coordinates outside a picture without tiles, whose border is continued there. Raises BadInput as
    `list_tiles`, `tiles_at` and `read_image`.
    """
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
