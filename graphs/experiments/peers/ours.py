"""Rods and networks of hairpipe, as `simulate_hair` steps them."""

from dataclasses import replace

import numpy as np

from hairpipe import __version__
from hairpipe.graphs.experiments.peers.hanging import FRAME, Hanging, Peer, Strands
from hairpipe.groom.strands import lay_strands, unbound
from hairpipe.laws.settings import Air, Drag, StepControl
from hairpipe.shot.settings import HairSettings
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import choose_precision, next_state
from hairpipe.strands.hair_model import build_models
from hairpipe.strands.registry import ModelName

TRUTH_SEGMENTS, TRUTH_STEPS = 200, 256
"""Segments, and steps a frame, of the converged run."""


def peers() -> list[Peer]:
    """List the settings that are compared; the first is the default of a user."""
    choices: list[tuple[ModelName, int, int]] = [("rod", 25, 4), ("rod", 50, 4), ("rod", 50, 16), ("network", 50, 4)]
    return [_peer(*choice) for choice in choices]


def converged(scene: Hanging) -> Strands:
    """Lay a strand that is resolved beyond all others: 200 segments, 15,360 steps a second, EA as it is."""
    fine = replace(scene, material=replace(scene.material, softening=1.0))
    return Ours(fine, 1, "rod", TRUTH_SEGMENTS, TRUTH_STEPS)


def _peer(model: ModelName, segments: int, steps: int) -> Peer:
    settings = f"{model}, EA / 100, TR-BDF2"
    return Peer(
        f"hairpipe {__version__}",
        settings,
        segments,
        steps,
        1000,
        lambda scene, strands: Ours(scene, strands, model, segments, steps),
    )


class Ours:
    """Strands of ours; see `Strands`."""

    def __init__(self, scene: Hanging, strands: int, model: ModelName, segments: int, steps: int) -> None:
        one = lay_strands(1, scene.length, segments, tuple(scene.direction), (0.0, 0.0, 0.0), None, 0.0)
        groom = unbound(np.stack([one.points] * strands), np.concatenate([one.root_frames] * strands))
        longest = StepControl(longest=FRAME / steps)
        self._settings = HairSettings(
            model=model, material=scene.material, gravity=scene.gravity, air=Air(Drag(scene.drag)), steps=longest
        )
        models = build_models(groom, scene.material, model, self._settings.construction)
        self._hair = choose_precision("automatic", models, self._settings, bodies=False)
        self._frame = 1
        self._state = next_state(self._hair, None, self._at(0.0), self._settings)

    def advance(self) -> None:
        """Advance by a frame."""
        self._state = next_state(self._hair, self._state, self._at(self._frame * FRAME), self._settings)
        self._frame += 1

    def points(self) -> np.ndarray:
        """Points of the first strand [m], (n, 3)."""
        return self._hair.layout.axis(self._state.positions)[: self._hair.groom.offsets[1]]

    def _at(self, began: float) -> Frame:
        return Frame((None, None), (), (), began, FRAME)
