"""Normals of hair as one body."""

from hairpipe.data import Ends, Groom, LevelSet, Mesh, Normals, Strands
from hairpipe.graph import node


@node(frames="each")
def carry_normals(hair: Strands, groom: Groom, shell: LevelSet, body: Mesh | None, ends: Ends | None) -> Normals:
    """Normals of the shell of the groom at rest, turned as the hair has been since, for `preview`.

    `shell` is that of the groom, without a body: `carry_groom`, `measure_density`, `mesh_shell`, `bake_levelset`. Body
    or ends are those that lead the roots.
    """
    from hairpipe.groom.keys.shell_normals import carried_normals, probe_shell
    from hairpipe.sim.boundary import lead_of, motion_of_roots

    rest = probe_shell(groom.points, shell).normal
    return carried_normals(rest, groom, hair, motion_of_roots(lead_of(body, ends), groom))
