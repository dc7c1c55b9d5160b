"""Solvers side by side: what a particle costs in each, and the error of a swing, a cantilever and a frequency."""

import time
from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report
from hairpipe.graphs.experiments.peers.hanging import FRAME, Hanging, Peer, Strands
from hairpipe.graphs.experiments.peers.registry import Adapter
from hairpipe.graphs.experiments.studies.theory.beam_modes import bending_frequencies, bending_roots
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica

SWING = Hanging(length=0.3, angle=60.0)
CANTILEVER = Hanging(length=0.1, angle=90.0, drag=25.0)
RINGING = Hanging(length=0.1, angle=90.0, gravity=0.12)
"""The swing; hair at rest under its weight, rho A g L^3 / (E I) = 8.2; the same hair, 82 times as light, undamped."""
TIMED = 12
"""Frames that are timed, after one which compiles."""


class Path(NamedTuple):
    """Motion of a strand: its tips [m], (frames + 1, 3), and the largest strain of it all."""

    tips: np.ndarray
    stretch: float


def measure_swing(
    echo: Echo,
    adapters: dict[str, Adapter],
    scenes: tuple[Hanging, Hanging, Hanging] = (SWING, CANTILEVER, RINGING),
    timed: int = TIMED,
) -> Report:
    """Measure every peer of the adapters, and report progress.

    scenes  swing, cantilever and small vibration
    timed   number of frames
    """
    swing, cantilever, ringing = scenes
    truths = dict[str, Path]()
    for name, adapter in adapters.items():
        if adapter.converged is not None:
            echo(f"a converged swing by {name}")
            truths[name] = follow(adapter.converged(swing), swing)
    cases = list[Case]()
    for name, adapter in adapters.items():
        for peer in adapter.peers():
            echo(f"{peer.solver}, {peer.segments} segments, {peer.steps} steps a frame: {peer.settings}")
            path = follow(peer.lay(swing, 1), swing)
            errors = {f"error to {truth} [%]": distance(path, of, swing) for truth, of in truths.items()}
            sag = follow(peer.lay(cantilever, 1), cantilever)
            wave = follow(peer.lay(ringing, 1), ringing)
            case: Case = {"name": name, "solver": peer.solver, "settings": peer.settings, "segments": peer.segments}
            case |= {"steps a frame": peer.steps, **costs(peer, swing, timed), **errors}
            case["stretch [%]"] = 100 * path.stretch
            case["cantilever [%]"] = sag_error(sag, cantilever)
            case["frequency [%]"] = frequency_error(wave, ringing)
            cases.append(case)
    apart: list[Case] = [
        {"a": a, "b": b, "difference [%]": distance(truths[a], truths[b], swing)}
        for a in truths
        for b in truths
        if a < b
    ]
    return make_report(__name__, {"peers": cases, "converged": apart})


def follow(strands: Strands, scene: Hanging) -> Path:
    """Simulate a scene; return the motion of the first strand."""
    points = strands.points()
    rest = np.linalg.norm(np.diff(points, axis=0), axis=1)
    tips = [points[-1]]
    stretch = 0.0
    for _ in range(scene.frames):
        strands.advance()
        points = strands.points()
        tips.append(points[-1])
        stretch = max(stretch, float((np.linalg.norm(np.diff(points, axis=0), axis=1) / rest).max()) - 1.0)
    return Path(np.array(tips), stretch)


def costs(peer: Peer, scene: Hanging, frames: int) -> Case:
    """Time many strands: medians of a frame, per segment of a strand; threads are what was busy on average."""
    strands = peer.lay(scene, peer.strands)
    strands.advance()
    walls, busy = list[float](), list[float]()
    for _ in range(frames):
        wall = time.perf_counter()
        processor = time.process_time()
        strands.advance()
        walls.append(time.perf_counter() - wall)
        busy.append(time.process_time() - processor)
    each = 1e6 / (peer.strands * peer.segments)
    wall, processor = float(np.median(walls)), float(np.median(busy))
    return {
        "strands": peer.strands,
        "wall [us]": each * wall,
        "processor [us]": each * processor,
        "threads in use": processor / wall,
    }


def distance(path: Path, truth: Path, scene: Hanging) -> float:
    """Distance of the tips of two motions, RMS over the frames [% of length]."""
    return 100 * float(np.sqrt(np.mean(np.sum((path.tips - truth.tips) ** 2, axis=1)))) / scene.length


def sag_error(path: Path, scene: Hanging) -> float:
    """Distance of the last tip of a horizontal strand from that of the elastica [% of length]."""
    fibre = scene.material
    tip = bend_elastica(fibre.line_density * scene.gravity * scene.length**3 / fibre.bending).tip
    return 100 * float(np.linalg.norm(path.tips[-1] / scene.length - [*tip, 0.0]))


def frequency_error(path: Path, scene: Hanging) -> float:
    """Error of the lowest bending frequency [%], by a fit of the height of the tip: two decaying modes of a beam."""
    from scipy.optimize import least_squares

    fibre = scene.material
    theory = float(bending_frequencies(1, scene.length, fibre.bending, fibre.line_density)[0])
    first, second = bending_roots(2)
    times = np.arange(len(path.tips)) * FRAME
    heights = path.tips[:, 1] / np.abs(path.tips[:, 1]).max()

    def misfit(given: np.ndarray) -> np.ndarray:
        ratio, rate, quick_rate = given
        phase = 2 * np.pi * theory * ratio * times
        quick = phase * (second / first) ** 2
        slow = np.exp(-rate * times)
        fast = np.exp(-quick_rate * times)
        shapes = (slow * np.cos(phase), slow * np.sin(phase), fast * np.cos(quick), fast * np.sin(quick))
        columns = np.stack([np.ones_like(times), *shapes], axis=1)
        return columns @ np.linalg.lstsq(columns, heights, rcond=None)[0] - heights

    found = least_squares(misfit, [1.0, 0.1, 0.1], bounds=([0.5, 0.0, 0.0], [1.5, 20.0, 200.0]))
    return 100 * (float(found.x[0]) - 1.0)
