"""What is no USD file is refused in one sentence, with the line where there is one."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.usd.stage import open_stage, open_whole

TEXT = b'#usda 1.0\ndef Xform "a"\n{\n    float b = \n}\n'


def make(name: str, data: bytes) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return write


def folder(parent: Path) -> Path:
    (parent / "a.usd").mkdir()
    return parent / "a.usd"


CASES = {
    "missing": (lambda p: p / "a.usd", "cannot be read: No such file"),
    "folder": (folder, "cannot be read: it is a directory"),
    "empty": (make("a.usda", b""), "the file is empty"),
    "other": (make("a.obj", b"v 0 0 0"), "not named like a USD file"),
    "garbage": (make("a.usd", b"hello"), "not a readable USD file"),
    "header": (make("a.usdc", b"PXR-USDC"), "not a readable USD file"),
    "zip": (make("a.usdz", b"PK\x03\x04 nothing"), "not a readable USD file"),
    "syntax": (make("a.usda", TEXT), "a.usda: not a readable USD file: line 4, column 5: Expected }"),
    "crlf": (
        make("a.usda", TEXT.replace(b"\n", b"\r\n")),
        "a.usda: not a readable USD file: line 4, column 5: Expected }",
    ),
    "latin": (make("a.usda", b'#usda 1.0\ndef Xform "\xe4" {}\n'), "not UTF-8"),
}


@pytest.mark.parametrize(("write", "message"), CASES.values(), ids=CASES)
def test_other_files_are_refused(tmp_path: Path, write: Callable[[Path], Path], message: str) -> None:
    path = write(tmp_path)
    with pytest.raises(BadInput) as caught:
        open_stage(path)
    assert message in str(caught.value) and path.name in str(caught.value) and "\n" not in str(caught.value)


def test_unreadable_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.usda").write_bytes(b"#usda 1.0\n")
    monkeypatch.setattr(os, "access", lambda *_: False)  # whoever may read everything is not refused
    with pytest.raises(BadInput, match=r"a\.usda: the file cannot be read: Permission denied"):
        open_stage(tmp_path / "a.usda")


def write_rates(folder: Path, outer: str, inner: str) -> Path:
    """Write a stage with a sublayer that has samples, with rates of both."""
    (folder / "in.usda").write_text(
        f'#usda 1.0\n({inner}\n)\ndef "x" {{\n double y.timeSamples = {{ 1: 2, 2: 3 }}\n}}\n'
    )
    (folder / "out.usda").write_text(f"#usda 1.0\n({outer}\n subLayers = [@in.usda@]\n)\n")
    return folder / "out.usda"


@pytest.mark.parametrize("rate", ["0", "-24", "nan", "inf"])
@pytest.mark.parametrize("layer", ["out.usda", "in.usda"])
def test_a_rate_that_is_not_positive_is_refused(tmp_path: Path, rate: str, layer: str) -> None:
    rates = {"out.usda": "", "in.usda": ""} | {layer: f"timeCodesPerSecond = {rate}"}
    with pytest.raises(BadInput, match=rf"{layer}: timeCodesPerSecond is {rate}"):
        open_whole(write_rates(tmp_path, *rates.values()), None, "refuse")


def test_layers_of_another_rate_are_named_with_the_remedy(tmp_path: Path) -> None:
    path = write_rates(tmp_path, "", "timeCodesPerSecond = 25")
    message = r"in\.usda has 25 time codes a second, out\.usda 24, as it states none.* multiplied by 0\.96 "
    with pytest.warns(UserWarning, match=message + r"\(timeCodesPerSecond = 25 in out\.usda keeps them"):
        assert open_whole(path, None, "refuse").GetAttributeAtPath("/x.y").GetTimeSamples() == [0.96, 1.92]
