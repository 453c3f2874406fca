"""Advice in messages: arguments in Python, options of the command on the terminal."""

import re
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
        ("with isoembed.glue('a net.svg')", "with 'isoembed glue a net.svg -o surface.ply'"),
        ('with isoembed.glue("o\'brien.svg")', "with 'isoembed glue o'brien.svg -o surface.ply'"),
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
