"""Deform all strands of a file of guides: `python deform_guides.py shot.usd all.usdc` needs OpenUSD and numpy alone.

The file is one of `export_usd` with `in.guidance`. /shot/hair has the guides at every frame, /shot/body the skin, and
/shot/strands all strands at rest, with guides and weights. The formula is that of the page "Simulate guides, show all
hair"; each line names what it computes.
"""

import sys
import time
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

TINY = 1e-12


class Strands:
    """Constant values of the file: those of the guides (G of them) and of all strands (S)."""

    def __init__(self, stage: Usd.Stage) -> None:
        root = stage.GetDefaultPrim()
        self.guides, self.body, self.strands = (root.GetChild(name) for name in ("hair", "body", "strands"))
        self.triangles = read(self.body, "faceVertexIndices").reshape(-1, 3)
        self.guide_rest = read(self.guides, "primvars:pref")
        self.rest = read(self.strands, "points")
        self.guide_counts = read(self.guides, "curveVertexCounts").astype(int)
        self.counts = read(self.strands, "curveVertexCounts").astype(int)
        self.guide_firsts, self.firsts = (np.cumsum(c) - c for c in (self.guide_counts, self.counts))
        self.offset = read(self.strands, "primvars:rootOffset")
        width = UsdGeom.PrimvarsAPI(self.strands).GetPrimvar("guideIndex").GetElementSize()
        self.index = read(self.strands, "primvars:guideIndex").reshape(-1, width)
        self.weight = read(self.strands, "primvars:guideWeight").reshape(-1, width)
        self.rest_frames = np.swapaxes(read(self.guides, "primvars:restFrame"), 1, 2)
        same = read(self.strands, "primvars:hairId")[:, None] == read(self.guides, "primvars:hairId")[self.index]
        self.itself = np.where(same[:, 0], self.index[:, 0], -1)  # A guide is drawn as it is.

    def at(self, frame: float) -> np.ndarray:
        """Return the points of all strands at a frame, (P, 3)."""
        skin = read(self.body, "points", frame)
        guides = read(self.guides, "points", frame)
        turns = self.turns(guides, self.frames(self.guides, skin)[0])
        frames, x = self.frames(self.strands, skin)
        x = x + np.einsum("sij,sj->si", frames, self.offset)
        points = np.empty_like(self.rest, shape=self.rest.shape)
        points[self.firsts] = x
        for k in range(self.counts.max() - 1):  # Point after point, all strands at a time.
            s = np.flatnonzero(self.counts > k + 1)
            rest = self.rest[self.firsts[s] + k + 1] - self.rest[self.firsts[s] + k]
            way = np.zeros((len(s), 3))
            for j in range(self.index.shape[1]):
                guide = self.index[s, j]
                below, share = middle(k, self.counts[s] - 1, self.guide_counts[guide] - 1)
                row = self.guide_firsts[guide] + below
                turned = np.einsum("sij,sj->si", turns[row], rest)
                if share.any():
                    above = np.einsum("sij,sj->si", turns[row + (share > 0.0)], rest)
                    turned += share[:, None] * (above - turned)
                way += self.weight[s, j, None] * turned
            x[s] += np.linalg.norm(rest, axis=1)[:, None] * unit(way)
            points[self.firsts[s] + k + 1] = x[s]
        for s in np.flatnonzero(self.itself >= 0):
            rows = np.arange(self.counts[s])
            points[self.firsts[s] + rows] = guides[self.guide_firsts[self.itself[s]] + rows]
        return points

    def frames(self, curves: Usd.Prim, skin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return frames of roots on the skin, (n, 3, 3), and their origins, (n, 3)."""
        a, b, c = np.moveaxis(skin[self.triangles[read(curves, "primvars:skinprim")]], 1, 0)
        uv = read(curves, "primvars:skinprimuv")
        tangent = unit(b - a)
        normal = unit(np.cross(b - a, c - a))
        origin = a + uv[:, :1] * (b - a) + uv[:, 1:] * (c - a)
        return np.stack([tangent, np.cross(normal, tangent), normal], axis=2), origin

    def turns(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Return rotations of the segments of guides since rest, (P', 3, 3): each is the smallest after that before."""
        turn = frames @ np.swapaxes(self.rest_frames, 1, 2)
        turns = np.zeros((len(points), 3, 3))
        for k in range(self.guide_counts.max() - 1):
            g = np.flatnonzero(self.guide_counts > k + 1)
            row = self.guide_firsts[g] + k
            u = unit(np.einsum("gij,gj->gi", turn[g], self.guide_rest[row + 1] - self.guide_rest[row]))
            t = unit(points[row + 1] - points[row])
            c = np.cross(u, t)
            cosine = np.einsum("gi,gi->g", u, t)
            across = np.cross(c[:, None], np.swapaxes(turn[g], 1, 2))  # c x each column, as rows
            again = np.cross(c[:, None], across)
            change = across + again / np.maximum(1.0 + cosine, TINY)[:, None, None]
            turn[g] += np.swapaxes(change, 1, 2)
            turns[row] = turn[g]
        return turns


def middle(k: int, segments: np.ndarray, theirs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the segment of a guide whose middle is before that of segment k of a strand, and the share of the next."""
    place = np.clip((2 * k + 1) * theirs - segments, 0, 2 * segments * (theirs - 1))
    return place // (2 * segments), place % (2 * segments) / (2 * segments)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return unit vectors."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), TINY)


def read(prim: Usd.Prim, name: str, frame: float | None = None) -> np.ndarray:
    """Return a value as an array, at a frame or constant; numbers in double precision."""
    value = np.array(prim.GetAttribute(name).Get(Usd.TimeCode.Default() if frame is None else frame))
    return value.astype(float) if value.dtype.kind == "f" else value


def main(source: str, target: str) -> None:
    """Write a layer over the file, with the points of all strands at all frames; print the time a frame."""
    stage = Usd.Stage.Open(str(source))
    strands = Strands(stage)
    over = Usd.Stage.CreateNew(str(target))
    over.GetRootLayer().subLayerPaths.append(str(Path(source).resolve()))
    over.SetDefaultPrim(over.OverridePrim(stage.GetDefaultPrim().GetPath()))
    prim = UsdGeom.BasisCurves(over.OverridePrim(strands.strands.GetPath()))
    prim.GetPrim().SetActive(True)
    frames = UsdGeom.BasisCurves(strands.guides).GetPointsAttr().GetTimeSamples()
    seconds = 0.0
    for frame in frames:
        begun = time.perf_counter()
        points = strands.at(frame)
        seconds += time.perf_counter() - begun
        box = [Gf.Vec3f(*points.min(axis=0)), Gf.Vec3f(*points.max(axis=0))]
        prim.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), frame)
        prim.GetExtentAttr().Set(box, frame)
    over.SetStartTimeCode(frames[0])
    over.SetEndTimeCode(frames[-1])
    over.Save()
    print(f"{len(strands.counts)} strands from {len(strands.guide_counts)}: {seconds / len(frames):.2f} s a frame")


if __name__ == "__main__":
    main(*sys.argv[1:])
