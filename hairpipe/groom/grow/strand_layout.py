"""Style of every single strand."""

from typing import NamedTuple

import numpy as np

from hairpipe.groom.grow.style import Comb, Curl, Style
from hairpipe.groom.painting.paint import Canvas
from hairpipe.groom.random_streams import stream
from hairpipe.spatial.triangles import Sites, normalized

GAP = 0.001  # between the skin and any hair beyond its root [m]
FLATTEST = 0.001  # pitch of a curl that is not taken for nothing [m]
BACK_OF_HEAD = 0.6  # how far the skin faces backwards where nothing is left of the parting


class Layout(NamedTuple):
    """Parameters of growth, one row per strand.

    roots      [m], (S, 3)
    ahead      unit direction of the hair at the skin, (S, 3)
    combs      pull where it touches the body, in units of gravity, (S, 3)
    layers     distance from the body at which it slides [m], (S,)
    lengths    [m], (S,)
    radii      of the curls [m], (S,); 0 for straight hair
    pitches    of the curls [m], (S,)
    phases     of the curls at the root [rad], (S,)
    """

    roots: np.ndarray
    ahead: np.ndarray
    combs: np.ndarray
    layers: np.ndarray
    lengths: np.ndarray
    radii: np.ndarray
    pitches: np.ndarray
    phases: np.ndarray


def lay_out(canvas: Canvas, style: Style, sites: Sites, frames: np.ndarray) -> Layout:
    """Return the layout of hair that grows from sites with given root frames, (S, 3, 4)."""
    roots, normals = frames[:, :, 3], frames[:, :, 2]
    combs = comb_pulls(canvas, style.comb, sites, roots, normals)
    lift = canvas.numbers(style.lift, "lift", sites)
    radii, pitches = curls(canvas, style.curl, sites)
    depth = stream(canvas.seed, "layer").random(len(roots))
    turn = stream(canvas.seed, "phase").random(len(roots))
    return Layout(
        roots=roots,
        ahead=leaving_directions(combs, normals, np.radians(lift)),
        combs=combs,
        layers=GAP + depth * style.volume + radii,
        lengths=canvas.numbers(style.length, "length", sites),
        radii=radii,
        pitches=pitches,
        phases=2.0 * np.pi * turn,
    )


def comb_pulls(canvas: Canvas, comb: Comb, sites: Sites, roots: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the pull of the comb on every strand, in units of gravity, (S, 3)."""
    pulls = comb.stray * stream(canvas.seed, "stray").normal(size=roots.shape)
    side = np.where(roots[:, 0] < comb.parting, -1.0, 1.0)
    parted = np.clip(1.0 + normals[:, 2] / BACK_OF_HEAD, 0.0, 1.0)
    pulls[:, 0] += side * parted * canvas.numbers(comb.sideways, "comb.sideways", sites)
    pulls[:, 2] -= canvas.numbers(comb.back, "comb.back", sites)
    return pulls


def leaving_directions(combs: np.ndarray, normals: np.ndarray, lift: np.ndarray) -> np.ndarray:
    """Return the unit directions at an angle lift [rad], (S,), to the skin, over the way the hair is pulled, (S, 3)."""
    pulls = combs + np.array((0.0, -1.0, 0.0))
    along = normalized(pulls - np.sum(pulls * normals, axis=1, keepdims=True) * normals)
    return normalized(np.cos(lift)[:, None] * along + np.sin(lift)[:, None] * normals)


def curls(canvas: Canvas, curl: Curl | None, sites: Sites) -> tuple[np.ndarray, np.ndarray]:
    """Return radius and pitch of the curl of every strand [m], (S,) each; the radius of straight hair is 0."""
    if curl is None:
        return np.zeros(len(sites.triangles)), np.ones(len(sites.triangles))
    radii = canvas.numbers(curl.radius, "curl.radius", sites)
    pitches = canvas.numbers(curl.pitch, "curl.pitch", sites)
    return np.where(pitches < FLATTEST, 0.0, radii), np.maximum(pitches, FLATTEST)
