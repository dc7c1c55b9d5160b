"""Draws scenes at random, to see whether what is promised of them is kept: graphs of a few hundred hairs on our bust.

What is drawn is spread over what shots differ by: length, curl, density, what hair does to hair, wind, and motion.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hairpipe.app.tune.measured import Tolerance
from hairpipe.engine.file.overrides import Tables
from hairpipe.values.random_streams import stream

HAIR = "hair"
"""Name of the node that simulates."""
FRAMES = (1001, 1040)
FPS = 24.0
SEGMENTS = 24
TURNS = (1.0, 3.0)
"""Of each strand; turns of a curl, which are eight segments each at the least."""
LENGTHS, STRANDS = (0.05, 0.35), (200.0, 800.0)
"""[m]; of both, logarithms are drawn evenly."""
TOLERANCES = (3.0, 5.0, 7.0, 10.0)
"""Of the length [%]."""
BETWEEN: tuple[tuple[str, ...], ...] = ((), ("stiction",), ("collisions",), ("stiction", "collisions"), ("volume",))
ODDS = (0.2, 0.15, 0.15, 0.4, 0.1)
"""What hair does to hair, and how often."""
CURLS, WINDS, GUSTS, SAG_FREE = 0.4, 0.35, 0.6, 0.5
"""How often hair is curled, wind blows, with gusts, and hair begins at rest."""
NECK = (0.0, 0.12, 0.0)
"""Through which our bust nods [m]."""
Motion = tuple[str, Tables]
"""In words, and the nodes `body`, `parts` and those behind them."""


@dataclass(frozen=True)
class DrawnScene:
    """A scene, and the same hair in a newly drawn motion.

    text    the hair, and what moves it, in words
    tables  of the graph; its node `hair` simulates
    other   the other motion in words, and the tables of the graph with it
    """

    text: str
    tolerance: Tolerance
    tables: Tables
    other: tuple[str, Tables]


def draw_scene(seed: int, number: int) -> DrawnScene:
    """Draw a scene: the same for the same seed and number, whatever others are drawn; pure.

    Files that it names lie in `assets` of the folder of shipped graphs.
    """
    random = stream(seed, f"scene {number}")
    grown, groom = draw_groom(random)
    between = BETWEEN[random.choice(len(BETWEEN), p=ODDS)]
    blown, wind = draw_wind(random)
    hair: Tables = {"type": "simulate_hair", "in": {"groom": "groom", "body": "body", "parts": "parts"}}
    hair |= {"strain": {"tolerance": 0.02}, "contact": {"friction": drawn(random, 0.1, 0.6)}, **wind}
    hair |= {group: {} for group in between} | ({"rest": {"balanced": 1.0}} if random.random() < SAG_FREE else {})
    tolerance = Tolerance(float(random.choice(TOLERANCES)), "%")
    moved, one = draw_motion(stream(seed, f"scene {number} motion"))
    moved_again, other = draw_motion(stream(seed, f"scene {number} other"), one)
    common = {"schema": 1, "frames": [*FRAMES], "fps": FPS, "head": {"type": "make_bust"}}
    tables, renewed = (common | nodes | {"groom": groom, HAIR: hair} for nodes in (one, other))
    text = ", ".join([grown, " and ".join(between) or "hairs apart", *blown, moved])
    return DrawnScene(text, tolerance, tables, (moved_again, renewed))


def draw_groom(random: np.random.Generator) -> tuple[str, Tables]:
    """Draw a groom, in words and as the table of a node."""
    length = even_by_ratio(random, LENGTHS)
    strands = round(even_by_ratio(random, STRANDS))
    groom: Tables = {"type": "grow_groom", "in": {"scalp": "head"}, "strands": strands, "segments": SEGMENTS}
    groom |= {"length": {"value": length, "variation": drawn(random, 0.0, 0.15)}, "seed": int(random.integers(1000))}
    groom |= {"lift": drawn(random, 20.0, 80.0), "bend": drawn(random, 0.02, 0.1)}
    text = f"{strands} hairs of {100 * length:.0f} cm"
    if random.random() >= CURLS:
        return f"{text}, straight", groom
    turn = length / drawn(random, *TURNS)
    slope = np.radians(drawn(random, 15.0, 45.0))
    radius = rounded(turn * np.sin(slope) / (2.0 * np.pi))
    pitch = rounded(turn * np.cos(slope))
    curl = {"radius": {"value": radius}, "pitch": {"value": pitch}, "onset": rounded(0.2 * length)}
    return f"{text}, curls of {1e3 * radius:.0f} mm", groom | {"curl": curl}


def draw_wind(random: np.random.Generator) -> tuple[list[str], Tables]:
    """Draw whether wind blows, in words and as settings."""
    if random.random() >= WINDS:
        return [], {}
    speed = drawn(random, 0.5, 3.0)
    bearing = drawn(random, 0.0, 2.0 * np.pi)
    wind: Tables = {"velocity": [rounded(speed * np.sin(bearing)), 0.0, rounded(speed * np.cos(bearing))]}
    if random.random() >= GUSTS:
        return [f"wind of {speed:.1f} m/s"], {"wind": wind}
    gusts = {"strength": rounded(0.5 * speed), "size": drawn(random, 0.1, 0.5), "seed": int(random.integers(1000))}
    return [f"gusts of {speed:.1f} m/s"], {"wind": wind | {"gusts": gusts}}


def draw_motion(random: np.random.Generator, like: Tables | None = None) -> Motion:
    """Draw how the bust moves; given the nodes of a motion, by such nodes: settings of these are part of a choice."""
    clips: tuple[Callable[[np.random.Generator], Motion], ...] = (shaken, danced)
    tracks: tuple[Callable[[np.random.Generator], Motion], ...] = (turned, nodding, thrown)
    kinds = (*clips, *tracks) if like is None else clips if "motion" in like else tracks
    return kinds[random.integers(len(kinds))](random)


def shaken(random: np.random.Generator) -> Motion:
    """Play the shake of a head."""
    speed = drawn(random, 0.5, 1.1)
    return f"shaken at {speed:.2f} of the speed", played("shake.bvh", 0.0, speed)


def danced(random: np.random.Generator) -> Motion:
    """Play some of a dance."""
    start, speed = drawn(random, 0.0, 8.0), drawn(random, 0.5, 1.1)
    return f"dance from {start:.1f} s on at {speed:.2f} of the speed", played("dance.bvh", start, speed)


def turned(random: np.random.Generator) -> Motion:
    """Turn about the vertical, now and then."""
    times = draw_times(random)
    angles = np.cumsum([0.0, *random.uniform(-90.0, 90.0, len(times) - 1)])
    turns = [rounded(angle) for angle in angles]
    most = np.abs(np.diff(angles)).max()
    return f"turns of up to {most:.0f} degrees", bust_motion({"times": times, "turn": turns, "axis": [0.0, 1.0, 0.0]})


def nodding(random: np.random.Generator) -> Motion:
    """Nod forwards and backwards."""
    times = draw_times(random)
    turns = [0.0, *(drawn(random, -20.0, 40.0) for _ in times[1:])]
    most = np.abs(np.diff(turns)).max()
    track = {"times": times, "turn": turns, "axis": [1.0, 0.0, 0.0], "pivot": [*NECK]}
    return f"nods of up to {most:.0f} degrees", bust_motion(track)


def thrown(random: np.random.Generator) -> Motion:
    """Move to and fro, up and down."""
    times = draw_times(random)
    reach = drawn(random, 0.03, 0.15)
    moves = [[0.0, 0.0, 0.0], *([drawn(random, -reach, reach) for _ in range(3)] for _ in times[1:])]
    return f"thrown about by {100 * reach:.0f} cm", bust_motion({"times": times, "move": moves})


def played(clip: str, start: float, speed: float) -> Tables:
    """Return nodes that play a clip on the bust."""
    motion = {"type": "load_motion", "in": {"rest": "head"}, "file": f"assets/{clip}", "start": start, "speed": speed}
    posed = {"rest": "head", "pose": "motion"}
    return {
        "motion": motion,
        "body": {"type": "pose_body", "in": posed},
        "parts": {"type": "bake_parts", "in": posed},
    }


def bust_motion(track: Tables) -> Tables:
    """Return nodes that carry the bust along keys."""
    return {
        "still": {"type": "pose_body", "in": {"rest": "head"}},
        "body": {"type": "move_mesh", "in": {"mesh": "still"}, "motion": track},
        "surface": {"type": "bake_levelset", "in": {"body": "still"}},
        "parts": {"type": "move_levelset", "in": {"surface": "surface"}, "motion": track},
    }


def draw_times(random: np.random.Generator) -> list[float]:
    """Draw when keys are, from the first frame to the last one, 0.25 to 0.5 s apart [s]."""
    times = np.cumsum([0.0, *random.uniform(0.25, 0.5, 8)])
    return [rounded(time) for time in times[times < (FRAMES[1] - FRAMES[0]) / FPS]]


def drawn(random: np.random.Generator, low: float, high: float) -> float:
    """Draw a number between two."""
    return rounded(random.uniform(low, high))


def even_by_ratio(random: np.random.Generator, between: tuple[float, float]) -> float:
    """Draw a number between two, its logarithm evenly."""
    return rounded(np.exp(random.uniform(*np.log(between))))


def rounded(value: float) -> float:
    """Round to three figures, as a person would write it in a graph."""
    return float(f"{value:.3g}")
