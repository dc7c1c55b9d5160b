"""History of the text of a graph: edits, undo and redo, and what another program does to the file meanwhile."""

from collections.abc import Callable
from difflib import unified_diff
from typing import Any, NamedTuple

from hairpipe.errors import BadInput

MOST_STEPS = 500
"""Maximum number of edits that can be undone."""

Deed = tuple[str, dict[str, Any]]


class Step(NamedTuple):
    """Text of a graph after an edit.

    label  description of the edit
    deed   verb and values of the edit, to repeat it in another text; None for a change by another program
    """

    label: str
    text: str
    deed: Deed | None = None


class History:
    """Texts of a graph, of which one is the present.

    disk    text of the file as last read or written; None for a file that does not exist
    theirs  text of the file, which another program has changed while there were unsaved edits; else None
    """

    def __init__(self, text: str, disk: str | None) -> None:
        self._steps = [Step("", text)]
        self._at = 0
        self._saved = 0
        self.disk = disk
        self.theirs: str | None = None

    @property
    def text(self) -> str:
        """The present text."""
        return self._steps[self._at].text

    @property
    def first(self) -> str:
        """The earliest text that is kept."""
        return self._steps[0].text

    @property
    def unsaved(self) -> bool:
        """Whether the present text differs from that of the file."""
        return self.text != self.disk

    def push(self, step: Step) -> None:
        """Add an edit after the present text; texts that were undone are lost."""
        self._steps = [*self._steps[: self._at + 1], step][-MOST_STEPS:]
        self._saved = self._saved - max(0, self._at + 2 - MOST_STEPS) if self._saved <= self._at else -1
        self._at = len(self._steps) - 1

    def seek(self, by: int) -> str:
        """Return the text of an earlier edit, or of one that was undone; BadInput if there is none."""
        if not 0 <= self._at + by < len(self._steps):
            raise BadInput("nothing to undo" if by < 0 else "nothing to redo")
        return self._steps[self._at + by].text

    def move(self, by: int) -> None:
        """Make the text of `seek` the present one."""
        self._at += by

    def written(self, text: str) -> None:
        """Note that the file has the present text."""
        self.disk, self.theirs, self._saved = text, None, self._at

    def deeds(self) -> list[Step]:
        """List the edits since the file was saved."""
        return self._steps[self._saved + 1 : self._at + 1] if self._saved >= 0 else self._steps[1 : self._at + 1]

    def repeated(self, edit: Callable[[str, Deed], str]) -> str:
        """Return the text of the other program with the unsaved edits repeated in it; BadInput where one cannot be."""
        text = self.text if self.theirs is None else self.theirs
        for step in self.deeds():
            text = edit(text, step.deed) if step.deed else text
        return text

    def document(self) -> dict[str, Any]:
        """Describe the unsaved edits, how far one can go back and forth, and a conflict as differences of lines."""
        labels = {str(step.deed and step.deed[1].get("target", step)): step.label for step in self.deeds()}
        undone = [f"undone: {step.label}" for step in self._steps[self._at + 1 : self._saved + 1]]
        sides = self.text.splitlines(), (self.theirs or "").splitlines()
        difference = unified_diff(*sides, "this page", "the file", lineterm="", n=1)
        return {
            "edits": [*labels.values(), *undone] or (["a new file"] if self.disk is None else []),
            "undo": self._steps[self._at].label if self._at else None,
            "redo": self._steps[self._at + 1].label if self._at + 1 < len(self._steps) else None,
            "conflict": None if self.theirs is None else list(difference),
        }
