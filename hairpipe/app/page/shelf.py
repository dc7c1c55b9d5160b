"""Results of shots by name, as documents that are made on request."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from hairpipe.app.api.graph_shot import GraphShot
from hairpipe.app.api.reports import Plan, Task
from hairpipe.app.api.shot import Record
from hairpipe.app.page.values import (
    Packed,
    document_of,
    faces_document,
    kinds_of,
    mesh_document,
    mesh_of,
    suffix_of,
)
from hairpipe.engine import File
from hairpipe.errors import BadInput


class Origin(NamedTuple):
    """Origin of an object: an output of a result of a shot."""

    shot: GraphShot
    task: Task
    record: Record
    output: str

    @property
    def kind(self) -> type:
        return self.shot.graph.nodes[self.task.node].type.outputs[self.output]


class Shelf:
    """Cached results of shots, as documents named `OBJECT.KIND`.

    most  maximum number of shown strands of a groom
    """

    def __init__(self, most: int) -> None:
        self.most = most
        self._places: dict[str, Origin] = {}
        self._faces: dict[str, Packed] = {}
        self._suffixes: dict[str, str | None] = {}

    def take(self, shot: GraphShot, found: Plan) -> None:
        """Add the results of a plan of a shot; earlier ones are kept."""
        for task, record in found.records.items():
            for name, output in record.outputs.items():
                self._places[output.object] = Origin(shot, task, record, name)

    def names(self) -> Iterator[str]:
        """Iterate over the names of all documents except triangles, which are known once a mesh was made."""
        for name, place in self._places.items():
            if place.shot.object_path(name).exists():
                yield from (f"{name}.{document}" for document in kinds_of(place.kind))

    def node_of(self, name: str) -> str:
        """Return the node of a document."""
        return self._places[name.rpartition(".")[0]].task.node

    def faces(self) -> dict[str, Packed]:
        """Documents of the triangles of all requested meshes, by name."""
        return dict(self._faces)

    def suffix(self, name: str) -> str | None:
        """Suffix of an object that is a picture, else None."""
        if name not in self._suffixes and name.endswith(".bin"):
            self._suffixes[name] = suffix_of(self._places[name].shot.object_path(name))
        return self._suffixes.get(name)

    def picture(self, name: str) -> bytes:
        """Read a picture by the name of its object; KeyError for an unknown one."""
        file = self._read(name)
        if not isinstance(file, File) or not self.suffix(name):
            raise KeyError(name)
        return file.path.read_bytes()

    def document(self, name: str, most: int | None = None) -> Packed:
        """Make a document by its name, optionally with another number of strands; KeyError for an unknown name.

        BadInput for a missing or damaged object, which the next run computes again.
        """
        whose, _, kind = name.rpartition(".")
        if kind == "faces":
            return self._faces[whose]
        value = self._read(whose)
        if kind not in kinds_of(self._places[whose].kind):
            raise KeyError(name)
        mesh = mesh_of(kind, value)
        if mesh is None:
            return document_of(kind, value, self.most if most is None else most)
        found = mesh_document(mesh)
        self._faces.setdefault(found[0]["faces"], faces_document(mesh))
        return found

    def _read(self, name: str) -> Any:
        place = self._places[name]
        try:
            return place.shot.read(place.task, place.record, place.output)
        except FileNotFoundError as error:
            raise BadInput("is no longer in the cache", where=name, right="a run, which computes it again") from error
