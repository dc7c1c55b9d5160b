"""The rule of words in CONTRIBUTING.md: help, messages, docstrings and pages in plain technical English."""

import ast
import itertools
import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from hairpipe.app.api.node_types import node_types
from hairpipe.app.cli.entry import commands
from hairpipe.engine.node.settings import Field, fields_of
from hairpipe.graphs.experiments.bench.commands import bench

from .sources import HOME, SOURCES, name_of, tree_of

PAGES = [*HOME.glob("*.md"), *(page for room in ("hairpipe", "graphs", "docs") for page in (HOME / room).rglob("*.md"))]
CATALOGUE = node_types(experiments=True)
FEWEST_WORDS, MOST_LETTERS = 3, 80
HANGING = frozenset(
    word
    for line in (
        "about above across after against all along also among and as at because before below beneath beside between",
        "beyond but by each else for from how if in inside into it its itself like likewise nor of off on once only",
        "onto or otherwise out outside over per since so than that their them then there they this those through to",
        "toward towards under unless until up upon what when where whether which while who whom whose why with",
        "within without would",
    )
    for word in line.split()
)
"""Words that continue a sentence: a help text that begins with one cannot be read without the name of its setting."""
PATTERNS = {
    r"(?<!there )\b(is|are|was|were) no (?!longer\b|more\b|less\b|\w+er\b)": "is not a",
    r"\b[io]n the mean\b": "on average",
    r"\banew\b(?!  )": "again",
    r"\bbeside\b(?!  )": "next to, in addition to, with",
    r"\b(give|gives|gave|given|giving) up\b": "stop, omit",
    r"\blooks? on\b": "ignore",
    r"\boff by\b": "an error of",
    r"\btold apart\b": "distinguished, significantly different",
    r"\bnobody cares\b": "imperceptible, negligible",
    r"\bkeeps? room\b": "resist compression",
    r"\bswallow": "contain",
    r"\b(let|lets|letting) go\b": "release",
    r", by turns,": "in turn",
    r"\buntold\b": "inconclusive",
}
"""Idioms, and the plain words in place of each; two spaces follow the name of a parameter in a docstring."""

PLAIN = frozenset(
    word
    for line in (
        "acceleration advance air alignment angle attraction axis basis centre code coefficient colour condition",
        "contact damping deviation diameter direction displacement distance divisor duration elevation equilibrium",
        "error extent factor field force form format formula frequency height helix increment integrator",
        "interpolation layout length limit method metre model modulus motion name number offset order oscillation",
        "parameter part path pigment placement position precision pressure pull quality radius rate ratio",
        "reduction removal repulsion rotation row scheme seed shading shape share simulation size solver spacing",
        "speed square stiffness storage strength thickness time treatment turbulence update variation vector",
        "velocity viscosity width",
    )
    for word in line.split()
)
"""Nouns that begin the help text of a setting and need no entry in the glossary."""
ENDS_PHRASE = frozenset(
    word
    for line in (
        "across along around at before between by called for from in kept lost of on over per that to whose with",
    )
    for word in line.split()
)
"""Words after the first noun of a help text."""

PRIVATE = {
    "anew",
    "beside",
    "carry",
    "carried",
    "carriers",
    "fates",
    "led",
    "put_right",
    "said",
    "says",
    "spoken",
    "told",
}
"""Everyday words that are not names of variables, functions and types."""
VAGUE_TEST = re.compile(
    r"test_(what|who|whatever|nobody)_|.*(?<!_there)_(is|are)_no_(?!more_|less_|[a-z]+er_)|.*_(anew|beside|said|told)(_|$)"
)
"""Names of tests without a noun as their subject, or with an idiom."""


def settings_of(fields: tuple[Field, ...], prefix: str) -> Iterator[tuple[str, str]]:
    """List the help texts of settings, and of the fields of groups, by dotted name."""
    for field in fields:
        yield prefix + field.name, field.help
        yield from settings_of(field.group, f"{prefix}{field.name}.")


def options_of(command: click.Command, name: str) -> Iterator[tuple[str, str]]:
    """List the help texts of the options of a command, and of those within a group."""
    for option in command.params:
        if isinstance(option, click.Option) and option.help:
            yield f"{name} {option.opts[-1]}", option.help
    if isinstance(command, click.Group):
        context = click.Context(command)
        for inner in command.list_commands(context):
            yield from options_of(command.get_command(context, inner), f"{name} {inner}")


def glossary() -> set[str]:
    """Read the terms of the glossary."""
    text = (HOME / "docs" / "glossary.md").read_text(encoding="utf-8")
    return set(re.findall(r"^(?!:)(\S.*)\n  \S", text, re.MULTILINE))


def first_noun(text: str) -> str:
    """Return the last word before the first preposition or sign of a help text, in the singular."""
    begin = re.split(r"[:;,.(]", text)[0].split()
    phrase = list(itertools.takewhile(lambda word: word not in ENDS_PHRASE, begin))
    word = phrase[-1].lower() if phrase else ""
    return word if word in PLAIN or not word.endswith("s") else word.removesuffix("s")


def idioms_in(text: str) -> list[str]:
    """Name the idioms in a text, each with plain words."""
    return [
        f"'{found[0].strip()}': {plain}" for idiom, plain in PATTERNS.items() if (found := re.search(idiom, text, re.I))
    ]


def faults_of(text: str) -> list[str]:
    """Name what is wrong with a help text."""
    words = re.findall(r"[\w'`.-]+", text)
    faults = [f"fewer than {FEWEST_WORDS} words"] if len(words) < FEWEST_WORDS else []
    if words and words[0].lower() in HANGING:
        faults.append(f"begins with '{words[0]}'")
    return faults + idioms_in(text)


def prose_of(page: Path) -> Iterator[tuple[int, str]]:
    """List the lines of a page, without those of code and of tables, which commands write."""
    is_code = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("```"):
            is_code = not is_code
        elif not is_code and not line.startswith(("    ", "|")):
            yield number, re.sub(r"`[^`]*`", "", line)


@pytest.mark.parametrize("name", CATALOGUE.names())
def test_help_of_a_setting_is_read_without_its_name(name):
    found = settings_of(fields_of(CATALOGUE.find(name)), f"{name}.")
    wrong = [f"{setting}: {text}: {faults}" for setting, text in found if (faults := faults_of(text))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("name", node_types().names())
def test_help_of_a_setting_begins_with_a_known_noun(name):
    found = settings_of(fields_of(CATALOGUE.find(name)), f"{name}.")
    wrong = [f"{setting}: {text}" for setting, text in found if first_noun(text) not in PLAIN | glossary()]
    assert not wrong, "\n".join(wrong)


def test_plain_nouns_are_in_use_and_not_in_the_glossary():
    helps = [text for name in node_types().names() for _, text in settings_of(fields_of(CATALOGUE.find(name)), "")]
    assert not PLAIN - {first_noun(text) for text in helps}
    assert not PLAIN & glossary()


def test_help_of_an_option_is_read_without_its_name():
    found = [*options_of(commands, "hairpipe"), *options_of(bench, "bench")]
    assert len(found) > 100
    wrong = [f"{option}: {text}: {faults}" for option, text in found if (faults := faults_of(text))]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    "text", ["of the band", "maximum density", "distance at which it lets go, at once", "is no hair"]
)
def test_a_help_text_against_the_rule_is_found(text):
    assert faults_of(text)


def test_messages_and_docstrings_have_no_idioms():
    wrong = [
        f"{name_of(path)}:{item.lineno + row}: {idioms}"
        for path in SOURCES
        for item in ast.walk(tree_of(path))
        if isinstance(item, ast.Constant) and isinstance(item.value, str)
        for row, line in enumerate(item.value.splitlines())
        if (idioms := idioms_in(line))
    ]
    assert not wrong, "\n".join(wrong)


def test_pages_have_no_idioms():
    wrong = [
        f"{name_of(page)}:{number}: {idioms}"
        for page in PAGES
        for number, line in prose_of(page)
        if (idioms := idioms_in(line))
    ]
    assert not wrong, "\n".join(wrong)


def find_tests(folder: Path) -> Iterator[tuple[str, str]]:
    """List files and names of tests."""
    for path in sorted(folder.rglob("test_*.py")):
        for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(item, ast.FunctionDef) and item.name.startswith("test_"):
                yield name_of(path), item.name


def test_names_of_tests_are_short_and_have_a_subject():
    wrong = [
        f"{path}: {name}"
        for path, name in find_tests(HOME / "tests")
        if len(name) > MOST_LETTERS or VAGUE_TEST.match(name)
    ]
    assert not wrong, "\n".join(wrong)


def names_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """List the names that a module defines: functions, types, parameters and variables, with their lines."""
    for item in ast.walk(tree):
        if isinstance(item, ast.FunctionDef | ast.ClassDef):
            yield item.lineno, item.name
        elif isinstance(item, ast.arg):
            yield item.lineno, item.arg
        elif isinstance(item, ast.Name) and isinstance(item.ctx, ast.Store):
            yield item.lineno, item.id


def test_names_in_code_are_terms_of_the_field():
    wrong = [
        f"{name_of(path)}:{line}: {name}"
        for path in SOURCES
        for line, name in names_in(tree_of(path))
        if name.strip("_").lower() in PRIVATE
    ]
    assert not wrong, "\n".join(wrong)
