"""Motion blur: pictures of hair and body at instants of the exposure are summed on the film.

Pictures are summed, and hair is not smeared along its path, so that occlusion is right at each instant. Few instants
would leave sharp copies of a hair: each strand has a time offset of its own, a fraction of the interval.
"""

from collections.abc import Iterator

import numpy as np

from hairpipe.data import Mesh, Strands
from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera
from hairpipe.render.shading.kajiya_kay import noise

STRIDE, MOST = 4.0, 16
"""Pixels that all but FEW of the points move between two instants; largest number of instants."""
FEW = 0.02


def instants(hair: Strands, body: Mesh, camera: Camera, shutter: float) -> Iterator[tuple[np.ndarray, Mesh]]:
    """Yield points of the hair [m], (p, 3) float64, and the body, at instants from -shutter/2 to shutter/2 [s].

    Both move with constant velocities. Raises BadInput where a velocity of the hair is not finite.
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
    """Return the number of instants for a continuous look of motion by `way`; both [m], (p, 3)."""
    begin = camera.project(points - 0.5 * way)
    end = camera.project(points + 0.5 * way)
    pixels = np.quantile(np.hypot(*(end - begin)[:, :2].T), 1.0 - FEW)
    return int(np.clip(np.ceil(pixels / STRIDE), 1, MOST))
