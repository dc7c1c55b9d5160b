"""A curtain whose rail goes to and fro swings as a hanging chain does; ten times as stiff, it goes with the rail."""

import numpy as np
import pytest
from scipy.special import jv

from hairpipe.particles.settings import Interaction

from .conftest import plate

FRAME, LENGTH, LOWER, DRAG, GRAVITY = 1 / 24, 0.2, 0.15, 3.0, 9.81
WAY = np.array([0.0, 0.0, 0.01])
"""Across the curtain, where it is thin: along it, hair that acts on hair stiffens it."""


def of_chain(rate):
    """Lag of the lower quarter [frames], and its swing over that of the rail; linear theory, z up from the tip:

    J0(2 k sqrt(z)) / J0(2 k sqrt(L)), g k^2 = w (w - i drag).
    """
    k, heights = np.sqrt(rate * (rate - 1j * DRAG) / GRAVITY), np.linspace(0.0, LENGTH - LOWER, 50)
    response = np.mean(jv(0, 2.0 * k * np.sqrt(heights))) / jv(0, 2.0 * k * np.sqrt(LENGTH))
    return -np.angle(response) / rate / FRAME, np.abs(response)


def swung(shot, rate, sag):
    """The same of the curtain, after three seconds."""

    def rail(frame):
        seconds = (frame + 1) * FRAME
        velocity = WAY * rate * np.cos(rate * seconds)
        return plate(WAY * np.sin(rate * seconds), velocities=np.tile(velocity, (3, 1)))

    hair, places = shot(interaction=Interaction(), sag=sag), []
    for frame in range(144):
        hair.run(1, lambda _, frame=frame: rail(frame))
        places.append((hair.state.points - hair.particles.points)[hair.particles.arcs > LOWER, 2].mean())
    phases = rate * FRAME * np.arange(73, 145)
    waves = np.stack([np.sin(phases), np.cos(phases), np.ones(72)], axis=1)
    sine, cosine, _ = np.linalg.lstsq(waves, np.array(places[72:]), rcond=None)[0]
    response = (sine + 1j * cosine) / WAY[2]
    return -np.angle(response) / rate / FRAME, np.abs(response)


@pytest.mark.parametrize("hertz", [1.0, 2.0])
def test_it_lags_and_swings_as_a_chain_does_and_hardly_at_ten_times_the_modulus(shot, hertz):
    rate = 2.0 * np.pi * hertz
    (lag, swing), (chain_lag, chain_swing) = swung(shot, rate, 0.1), of_chain(rate)
    assert abs(lag - chain_lag) < 1.0 and swing == pytest.approx(chain_swing, rel=0.2)
    assert swung(shot, rate, 0.01)[0] < 1.0
