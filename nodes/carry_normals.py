"""Normals of the shell of hair, for its shading."""

from hairpipe.engine import node
from hairpipe.values import Ends, Groom, LevelSet, Mesh, Normals, Strands


@node(frames="each")
def carry_normals(hair: Strands, groom: Groom, shell: LevelSet, body: Mesh | None, ends: Ends | None) -> Normals:
    """Rotate the normals of the groom's shell with the strands, for `preview`.

    `shell` is the shell of the groom without a body: `carry_groom`, `measure_density`, `mesh_shell`, `bake_levelset`.
    `body` or `ends` are the inputs that move the roots.
    """
    from hairpipe.groom.interpolating import probe_shell, rotated_normals
    from hairpipe.solve.boundary import driver_of, motion_of_roots

    rest = probe_shell(groom.points, shell).normal
    return rotated_normals(rest, groom, hair, motion_of_roots(driver_of(body, ends), groom))
