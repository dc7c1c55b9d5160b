"""The film has all frames, at the speed of the shot."""

from pathlib import Path

import numpy as np
from PIL import Image

from hairpipe.engine import File, Frames, Time, Workspace
from hairpipe.formats.pictures import write_png
from hairpipe.nodes.flipbook import flipbook


def test_shows_the_frames_in_order_at_the_speed_of_the_shot(tmp_path: Path) -> None:
    numbers = (1001, 1002, 1004, 1010)
    for n in numbers:
        write_png(tmp_path / f"{n}.png", np.full((24, 32, 3), (n - 1000) * 20, np.uint8))
    pictures = Frames(numbers, lambda n: File(tmp_path / f"{n}.png"))
    film = flipbook(pictures, Time(1001, 25.0), Workspace(tmp_path), scale=0.5, quality=90)
    with Image.open(film.path) as image:
        assert image.n_frames == 4 and image.size == (16, 12)
        for place, (n, duration) in enumerate(zip(numbers, (40, 80, 240, 40), strict=True)):
            image.seek(place)
            shown = np.asarray(image.convert("RGB"))
            assert abs(shown.mean() - (n - 1000) * 20) < 4 and image.info["duration"] == duration
