import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.text import parse_number, read_text


def test_text_is_read_without_its_byte_order_mark(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert read_text(path) == "a\nb\nc\n"


@pytest.mark.parametrize(
    ("content", "message"), [(b"", "empty"), (b" \n\t", "empty"), (b"ab\xff", "byte 2 is not UTF-8")]
)
def test_invalid_texts_are_refused(tmp_path, content, message):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=message):
        read_text(path)


def test_unreadable_files_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none", tmp_path / "none" / "below"):
        with pytest.raises(BadInput, match="cannot be read"):
            read_text(path)


NUMBERS = {
    "1": 1.0,
    "-1e-5": -1e-5,
    ".5": 0.5,
    "nan": None,
    "inf": None,
    "1e999": None,
    "-1e200": None,
    "x": None,
    "": None,
}


@pytest.mark.parametrize(("word", "value"), NUMBERS.items())
def test_numbers_are_finite(word, value):
    assert parse_number(word) == value


def test_a_file_that_is_too_large_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "a.txt"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # of which nothing is on the disk
    with pytest.raises(
        BadInput, match=r"too large: 1,099,511,627,776 bytes \(a text file of at most 67,108,864 bytes\)"
    ):
        read_text(path)
