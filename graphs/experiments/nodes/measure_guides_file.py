"""Size of a file of guides, and time to deform all strands from it."""

from hairpipe.engine import File, node
from hairpipe.values import Table


@node(frames="once")
def measure_guides_file(all: File, guides: File) -> Table:
    """Measure the sizes of a file of all strands and of one of guides, and the reader of docs/howto/guides.md: one row.

    The reader deforms all strands at every frame on one thread. Its distances from the file of all strands are those of
    `choose_guides`, at all frames.
    """
    from hairpipe.graphs.experiments.measure.guides import file_table

    return file_table(all.path, guides.path)
