"""Nearest points on triangles, by brute force: a few roots over a body, once a shot."""

import numpy as np

BLOCK = 1 << 17  # pairs of point and triangle at once


def nearest_on_triangles(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return for points (p, 3) the nearest of triangles (t, 3, 3), (p,) int64, and its corners' weights, (p, 3)."""
    size = max(1, BLOCK // len(triangles))
    blocks = [_nearest(points[i : i + size], triangles) for i in range(0, len(points), size)]
    return np.concatenate([face for face, _ in blocks]), np.concatenate([weights for _, weights in blocks])


def _nearest(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = np.moveaxis(triangles, 1, 0)
    weights = _project(points[:, None], a, b, c)
    candidates = [np.where((weights >= 0).all(axis=-1, keepdims=True), weights, np.nan)]
    candidates += [_on_edge(points[:, None], triangles, i, (i + 1) % 3) for i in range(3)]
    stacked = np.stack(candidates)
    places = np.einsum("kptc,tcx->kptx", stacked, triangles)
    distances = np.nan_to_num(((places - points[:, None]) ** 2).sum(axis=-1), nan=np.inf)
    best = distances.min(axis=0).argmin(axis=1)
    kind = distances[:, np.arange(len(points)), best].argmin(axis=0)
    return best, stacked[kind, np.arange(len(points)), best]


def _project(points: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the weights of the corners at the foot of the perpendicular; NaN for triangles without area."""
    e, f, d = b - a, c - a, points - a
    ee = (e * e).sum(-1)
    ef = (e * f).sum(-1)
    ff = (f * f).sum(-1)
    de = (d * e).sum(-1)
    df = (d * f).sum(-1)
    area = ee * ff - ef * ef
    with np.errstate(divide="ignore", invalid="ignore"):
        v, w = (ff * de - ef * df) / area, (ee * df - ef * de) / area
    return np.stack([1 - v - w, v, w], axis=-1)


def _on_edge(points: np.ndarray, triangles: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return the weights of the corners at the nearest point of the edge from corner i to j."""
    start = triangles[:, i]
    along = triangles[:, j] - triangles[:, i]
    square = np.maximum((along * along).sum(-1), np.finfo(np.float64).tiny)
    share = np.clip(((points - start) * along).sum(-1) / square, 0, 1)
    weights = np.zeros((*share.shape, 3))
    weights[..., i] = 1 - share
    weights[..., j] = share
    return weights
