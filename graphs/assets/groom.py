"""A bob on the bust, as exported by a DCC, in centimetres. Running it writes groom.usda."""

from pathlib import Path

from hairpipe.body.bust import build_bust
from hairpipe.formats.pictures import read_image
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Style
from hairpipe.values import Groom
from hairpipe.values.painting import Canvas, PaintedDegrees, PaintedMetres

STRANDS, POINTS = 300, 12
HEAD = """#usda 1.0
(
    defaultPrim = "bob"
    metersPerUnit = 0.01
    upAxis = "Y"
)
def BasisCurves "bob"
{
    uniform token type = "linear"
    uniform token wrap = "nonperiodic"
    uniform token subdivisionScheme = "none"
"""


def grow_bob() -> Groom:
    """Return the hair, in metres."""
    style = Style(length=PaintedMetres(value=0.2, map="length", variation=0.05), lift=PaintedDegrees(value=55.0))
    return grow(Canvas(build_bust(), read_image, 7), style, None, STRANDS, Cut(segments=POINTS - 1))


def write_groom(path: Path, groom: Groom) -> None:
    """Write strands as curves of a USD file, to a tenth of a millimetre."""
    points = ", ".join("({:.2f}, {:.2f}, {:.2f})".format(*point) for point in 100.0 * groom.points)
    counts = ", ".join(map(str, groom.offsets[1:] - groom.offsets[:-1]))
    lines = [f"    int[] curveVertexCounts = [{counts}]", f"    point3f[] points = [{points}]"]
    lines += ['    float[] widths = [0.008] (\n        interpolation = "constant"\n    )', "}"]
    path.write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write_groom(Path(__file__).with_suffix(".usda"), grow_bob())
