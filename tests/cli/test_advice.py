"""Advice in messages: arguments in Python, options of the command on the terminal."""

import json
import re
import shlex
from pathlib import Path

import pytest

import isoembed
from isoembed.cli.advice import in_options


@pytest.mark.parametrize(
    ("argument", "option"),
    [
        ("method=Alexandrov(repair=5.3e-06) finds", "--method alexandrov --repair 5.3e-06 finds"),
        ("a longer search: method=Aim(effort=10).", "a longer search: --effort 10."),
        ("the best fit, method=Aim(best_fit=True)", "the best fit, --best-fit"),
        ('flow by it (method="paper") may', "flow by it (--method paper) may"),
        ("boundary='free' is", "--boundary free is"),
        ("merge them with merge=1e-05.", "merge them with --merge 1e-05."),
        ("allow it: tolerance=0.02 moves", "allow it: --tolerance 0.02 moves"),
        ("marginal=True or marginal=False decides", "--marginal or --not-marginal decides"),
        ("pass it as geometry=", "pass it as --geometry"),
        ("about 3 and not 0.29; length_errors=3 takes", "about 3 and not 0.29; --length-error 3 takes"),
        ("give length_errors=E; length_errors=0 takes", "give --length-error E; --length-error 0 takes"),
        ("only; isoembed.realizations(embedding) searches", "only; isoembed realizations SURFACE searches"),
        ("(method=Aim(effort=10)).", "(--effort 10)."),
        ("with isoembed.glue('a  net.svg')", "with `isoembed glue 'a  net.svg' -o surface.ply`"),
        ("with isoembed.embed('m.npz')", "with 'isoembed embed m.npz -o surface.ply'"),
        ("edges_foldAngle, for isoembed.glue, or", "edges_foldAngle, for 'isoembed glue', or"),
        ("as isoembed.io.write_net writes them", "as 'isoembed unfold' writes them"),
        ("and isoembed.relativity.read_slice reads one", "and 'isoembed series' reads several"),
        ("the residual is 1e-05, not 2", "the residual is 1e-05, not 2"),
        ("there is no file merge=1e-6.obj", "there is no file merge=1e-6.obj"),
        ("geometry=5.npz, a/tolerance=3/b.npz", "geometry=5.npz, a/tolerance=3/b.npz"),
    ],
)
def test_arguments_become_options(argument, option):
    assert in_options(argument) == option


@pytest.mark.parametrize("name", ["m.npz", "a  metric.npz", "o'brien.npz", "\"a\" 'b'.npz", "$(a)`b`\\n.npz"])
def test_commands_are_as_a_shell_takes_them(name):
    for source, words in [
        (f"embed it first, with isoembed.embed({name!r})", ["embed", name, "-o", "surface.ply"]),
        (f"glue it first, with isoembed.glue({name!r})", ["glue", name, "-o", "surface.ply"]),
        (f"isoembed.relativity.read_grid_data({name!r}) reads it", ["triangulate", name]),
    ]:
        advised = in_options(source)
        assert shlex.split(advised.split("with ")[-1][1:-1]) == ["isoembed", *words]
        assert advised[-1] == "'`"[shlex.quote(name) != name]


@pytest.mark.parametrize(
    ("words", "advice"),
    [
        (["glue", "{}"], "`isoembed glue '{}' --metric metric.npz` and then"),
        (["{}"], "; to embed a file: isoembed embed '{}'"),
        (["embed", "m.npz", "-o", "{}.png"], "did you mean --picture '{}.png'?"),
        (["embed", "m.npz", "n.npz", "{}.d"], "did you mean -o '{}.d'?"),
        (["surface", "sphere", "--vertices", "12", "{}"], "did you mean -o '{}'?"),
    ],
)
def test_advised_file_names_are_quoted(words, advice, call):
    name = "a  net.json"  # two blanks
    vault = {"polygons": [{"regular": 3}] * 4, "corners": ["abe", "bce", "cde", "dae"], "any_surface": True}
    Path(name).write_text(json.dumps(vault))
    status, _, err = call(*(word.format(name) for word in words))
    assert status == 2
    assert advice.format(name) in err


@pytest.mark.parametrize("path", [r"'\x'", r"'\U00110000'", "'a\nb'", r"'\'"])
def test_what_is_no_string_of_python_is_left(path):
    message = f"hub isoembed.embed({path}) is in one strut"
    assert in_options(message) == message


def test_the_library_names_no_options_or_commands():
    package = Path(isoembed.__file__).parent
    strings = re.compile(r"""["'].*?(?<![-\w`])--[a-z][a-z-]+|(?<!`)['`]isoembed [a-z]""")
    found = [
        f"{path.relative_to(package)}:{number}: {line.strip()}"
        for path in package.rglob("*.py")
        if path.parent.name != "cli" and path.name != "workers.py"
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if strings.search(line)
    ]
    assert found == []
