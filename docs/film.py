"""`make film GRAPH=demo`: compute the pictures of a graph in small, make the film of its card, and record its run."""

import os
import sys

import hairpipe
from extension.films import FILMS, HOME, Film, films
from hairpipe.app.api.selection import read_frames
from hairpipe.app.cli.options import parsed
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import write_webp
from hairpipe.graphs.experiments.figures.recording import Recording

QUALITY = 60
"""Quality of the compression: at 240 pixels higher values show no more."""


def make_film(film: Film) -> str:
    """Compute, write and record a film, and return its path; BadInput where code is not committed or the run fails."""
    settings = dict(assignment.split("=", 1) for assignment in film.settings)
    graph = HOME / f"graphs/{film.graph}.toml"
    shot = hairpipe.load(graph, parsed(settings))
    name = os.path.relpath(FILMS / film.graph, graph.parent)
    recording = Recording(shot, name, settings, read_frames(film.frames), [film.picture])
    done = shot.run(film.frames, to=film.picture)
    if not done.ok:
        raise BadInput("the run has failed", where=graph, right="\n".join(done.failure_lines()))
    pictures = {frame: file.path for frame, file in shot.get(film.picture, frames=film.frames).items()}
    film.path.parent.mkdir(parents=True, exist_ok=True)
    write_webp(film.path, list(pictures), pictures.__getitem__, fps=shot.fps, scale=1.0, quality=QUALITY)
    recording.write(done)
    return str(film.path.relative_to(HOME))


def main(names: list[str]) -> None:
    """Make the films of some graphs, or of all."""
    listed = films()
    try:
        for name in names or listed:
            if name not in listed:
                raise BadInput(f"no film of '{name}'", right="a graph of docs/films/films.toml")
            print(make_film(listed[name]), flush=True)
    except BadInput as fault:
        sys.exit(f"film: {fault}")


if __name__ == "__main__":
    main(sys.argv[1:])
