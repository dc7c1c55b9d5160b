"""Motion blur: hair and body at instants while the shutter is open, whose pictures are added up on the film.

Pictures are added, rather than every piece of hair smeared along its way: at each instant what is nearer covers what is
farther, hair as well as body. Few instants would leave as many sharp copies of a hair; so each strand is early or late
by a part of the step between them that is its own.
"""

from collections.abc import Iterator

import numpy as np

from hairpipe.data import Mesh, Strands
from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera
from hairpipe.render.shading.kajiya_kay import noise

STRIDE, MOST = 4.0, 16
"""Pixels that all but FEW of the points move between two instants, and the most of these."""
FEW = 0.02


def instants(hair: Strands, body: Mesh, camera: Camera, shutter: float) -> Iterator[tuple[np.ndarray, Mesh]]:
    """Yield points of the hair [m], (p, 3) float64, and the body, at instants from -shutter/2 to shutter/2 [s].

    Both move on with the velocities that they have. Raises BadInput where one of the hair's is not finite.
    """
    points = np.asarray(hair.points, float)
    if shutter == 0.0:
        yield points, body
        return
    if not np.isfinite(hair.velocities).all():
        raise BadInput("a velocity is not finite", where="hair", right="shutter = 0 draws hair without velocities")
    way = shutter * hair.velocities.astype(float)
    count = instants_of(points, way, camera)
    late = np.repeat(0.5 * noise(len(hair.offsets) - 1, 4), np.diff(hair.offsets))[:, None]
    for n in range(count):
        part = (n + 0.5) / count - 0.5
        yield points + (part + late / count) * way, Mesh(body.points + part * shutter * body.rates, body.triangles)


def instants_of(points: np.ndarray, way: np.ndarray, camera: Camera) -> int:
    """Say how many instants make motion by `way` look continuous; both [m], (p, 3)."""
    begin = camera.project(points - 0.5 * way)
    end = camera.project(points + 0.5 * way)
    pixels = np.quantile(np.hypot(*(end - begin)[:, :2].T), 1.0 - FEW)
    return int(np.clip(np.ceil(pixels / STRIDE), 1, MOST))
