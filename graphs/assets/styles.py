"""A fringe, a tied ponytail and a beard on the bust, as three groups of one file. Running it writes styles.usda."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from hairpipe.body.bust import EARS, build_bust
from hairpipe.body.scalp import smooth_step
from hairpipe.formats.pictures import read_image
from hairpipe.geometry.triangle_tree import nearest_sites
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Comb, Style
from hairpipe.values import Body, Groom
from hairpipe.values.painting import Canvas, Painted, PaintedDegrees, PaintedMetres
from hairpipe.values.triangles import site_points, unit_normals

TIE = np.array([0.0, 0.375, -0.118])
"""Place of the hair tie [m]: `pin_hair` of graphs/styles.toml has it, too."""
TAIL, BUNDLE = 0.24, 0.009  # length of the hair beyond the tie, and radius of the bundle in it [m]
FRINGE, PONYTAIL, BEARD = 300, 600, 500  # strands
HEAD = """#usda 1.0
(
    defaultPrim = "styles"
    metersPerUnit = 0.001
    upAxis = "Y"
)
def Xform "styles"
{
"""


def on_head(body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Return the elevation and the azimuth from the face of all vertices, as seen from between the ears [deg]."""
    x, y, z = (body.mesh.points - EARS).T
    return np.degrees(np.arctan2(y, np.hypot(x, z))), np.degrees(np.arctan2(np.abs(x), z))


def painted(body: Body, scalp: np.ndarray) -> Body:
    """Return a body whose hair grows where a map, (n,), is not 0."""
    return replace(body, maps={**body.maps, "scalp": scalp})


def grow_fringe(body: Body, front: np.ndarray) -> Groom:
    """Return hair of the front of the scalp, combed over the forehead."""
    comb = Comb(sideways=Painted(0.15), back=Painted(-1.5), stray=0.1)
    style = Style(PaintedMetres(0.08, variation=0.06), PaintedDegrees(25.0), bend=0.02, volume=0.006, comb=comb)
    return grow(Canvas(painted(body, body.maps["scalp"] * front), read_image, 3), style, None, FRINGE, Cut(segments=12))


def grow_beard(body: Body) -> Groom:
    """Return short hair of chin and jaw."""
    elevation, azimuth = on_head(body)
    heights = body.mesh.points[:, 1]
    jaw = smooth_step(-elevation, 32.0, 40.0) * smooth_step(-azimuth, -72.0, -60.0) * smooth_step(heights, 0.195, 0.205)
    style = Style(PaintedMetres(0.03, variation=0.15), PaintedDegrees(35.0), bend=0.012, volume=0.004)
    return grow(Canvas(painted(body, jaw), read_image, 5), style, None, BEARD, Cut(segments=6))


def lay_over(body: Body, roots: np.ndarray, layers: np.ndarray) -> np.ndarray:
    """Return shortest ways from roots (S, 3) to the tie, layers [m] above the skin, (S, 40, 3)."""
    share = np.linspace(0.0, 1.0, 40)[:, None]
    ways = roots[:, None] + share * (TIE - roots)[:, None]
    normals = unit_normals(body.mesh)
    for _ in range(60):
        inner = ways[:, 1:-1]
        inner[:] = 0.5 * inner + 0.25 * (ways[:, :-2] + ways[:, 2:])
        flat = inner.reshape(-1, 3)
        sites, _ = nearest_sites(body.mesh, flat)
        outward = normals[sites.triangles]
        gaps = np.einsum("ki,ki->k", flat - site_points(body.mesh, sites), outward)
        need = np.repeat(layers, 38) * np.tile(np.minimum(4.0 * share[1:-1, 0], 1.0), len(roots))
        inner[:] = (flat + np.maximum(need - gaps, 0.0)[:, None] * outward).reshape(inner.shape)
    return ways


def tie_ponytail(body: Body, front: np.ndarray) -> Groom:
    """Return the rest of the hair, which lies on the head up to the tie and hangs from it."""
    back = painted(body, body.maps["scalp"] * (1.0 - front))
    groom = grow(Canvas(back, read_image, 4), Style(PaintedMetres(0.1)), None, PONYTAIL, Cut(segments=24))
    random = np.random.default_rng(6)
    count = len(groom.ids)
    ways = lay_over(body, groom.points[groom.offsets[:-1]], random.uniform(0.003, 0.008, count))
    offset = random.normal(size=(count, 3)) * 0.5 * BUNDLE
    along = np.linspace(0.0, 1.0, 30)[:, None]
    hanging = np.concatenate([0.0 * along, 0.02 * along - 0.9 * along**2, -0.75 * along * (1 - 0.55 * along)], axis=1)
    spread = (1.0 + 1.2 * along)[None] * offset[:, None]
    tails = TIE + TAIL * hanging + spread
    ways += np.linspace(0.0, 1.0, 40)[None, :, None] ** 4 * offset[:, None]
    points = [even(np.concatenate([way, tail[1:]]), 24) for way, tail in zip(ways, tails, strict=True)]
    return replace(groom, points=np.concatenate(points))


def even(curve: np.ndarray, segments: int) -> np.ndarray:
    """Return a curve, (n, 3), of so many segments of one length along it."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    places = np.linspace(0.0, along[-1], segments + 1)
    return np.stack([np.interp(places, along, curve[:, c]) for c in range(3)], axis=1)


def curves_of(name: str, groom: Groom) -> str:
    """Write a group as curves of a USD file, to a tenth of a millimetre."""
    points = ", ".join("({:.1f}, {:.1f}, {:.1f})".format(*point) for point in 1000.0 * groom.points)
    counts = ", ".join(map(str, np.diff(groom.offsets)))
    names = ", ".join([f'"{name}"'] * len(groom.ids))
    return f"""    def BasisCurves "{name}"
    {{
        uniform token type = "linear"
        uniform token wrap = "nonperiodic"
        uniform token subdivisionScheme = "none"
        int[] curveVertexCounts = [{counts}]
        point3f[] points = [{points}]
        float[] widths = [0.08] (
            interpolation = "constant"
        )
        uniform string[] primvars:groom_group_name = [{names}] (
            interpolation = "uniform"
        )
    }}
"""


if __name__ == "__main__":
    bust = build_bust()
    high, side = on_head(bust)
    forehead = smooth_step(-side, -58.0, -48.0) * smooth_step(-high, -78.0, -70.0)
    groups = {
        "fringe": grow_fringe(bust, forehead),
        "ponytail": tie_ponytail(bust, forehead),
        "beard": grow_beard(bust),
    }
    text = HEAD + "".join(curves_of(name, groom) for name, groom in groups.items()) + "}\n"
    Path(__file__).with_suffix(".usda").write_text(text, encoding="utf-8")
