"""Help, examples, completion: what a command says of itself."""

import argparse
import re
import shlex
import subprocess
import sys

import pytest

from isoembed.cli import build_parser, main
from isoembed.cli.help import COMMANDS, FIRST_STEPS, GROUPS

OPTION = re.compile(r"^  (?:-\w[^,\n]*, )?(--[a-z-]+)", re.MULTILINE)


def parser_of(command):
    (subparsers,) = (
        action
        for action in build_parser([command])._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    return subparsers.choices[command]


def options_of(command):
    actions = [action for action in parser_of(command)._actions if action.help is not argparse.SUPPRESS]
    return {names[-1] for action in actions if (names := action.option_strings)}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_short_and_has_examples_and_exit_statuses(command, call):
    status, out, _ = call(command, "--help")
    assert status == 0
    listed = OPTION.findall(out)
    assert len(listed) <= 12
    assert set(listed) <= options_of(command)
    hidden = options_of(command) - set(listed)
    assert bool(hidden) == (f"{len(hidden)} more options: isoembed {command} --help-all" in out)
    assert out.count(f"\n  isoembed {command}") == 2
    for words in ("0 done;", "2 wrong", "3 no embedding", "130 interrupted"):
        assert words in out
    status, every, _ = call(command, "--help-all")
    assert status == 0
    assert sorted(OPTION.findall(every)) == sorted(options_of(command))


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_are_command_lines(command):
    for line in parser_of(command).examples:
        program, *words = shlex.split(line)
        assert program == "isoembed"
        build_parser(words).parse_args(words)


@pytest.mark.parametrize("command", COMMANDS)
def test_options_have_a_group(command):
    grouped = {name for names in GROUPS.values() for name in names}
    alone = {a.dest for a in parser_of(command)._actions if a.option_strings} - grouped
    assert alone <= {"help", "help_all", "list"}


def test_commands_are_listed_in_groups(call):
    out = call("--help")[1]
    for title in ("surfaces:", "proofs and errors:", "paper:", "relativity:"):
        assert f"\n{title}\n" in out
    for command in COMMANDS:
        assert re.search(rf"^  {command}\b", out, re.MULTILINE)
    for line in FIRST_STEPS.splitlines()[1:]:
        words = shlex.split(line)[1:]
        build_parser(words).parse_args(words)


def test_every_command_can_be_quiet():
    for command in set(COMMANDS) - {"surface"}:
        assert "--quiet" in options_of(command)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["emebd", "a.ply"], "unknown command 'emebd'; did you mean 'embed'?"),
        (
            ["embed", "a.ply", "--best-fitt"],
            "arguments: --best-fitt; did you mean '--best-fit'?",
        ),
        (["surface", "elipsoid"], "did you mean 'ellipsoid'?"),
        (
            ["view", "a.ply", "-o", "a.png", "--color", "gausian-curvature"],
            "did you mean 'gaussian-curvature'?",
        ),
        (["nets", "latin-cros"], "did you mean 'latin-cross'?"),
    ],
)
def test_what_is_mistyped_is_answered_with_what_is_near(words, said, call):
    assert said in call(*words)[2]


@pytest.mark.parametrize("spelling", ["gaussian-curvature", "Gaussian curvature", "gaussian_curvature"])
def test_colors_need_no_quotes(spelling):
    words = ["view", "a.ply", "-o", "a.png", "--color", spelling]
    assert build_parser(words).parse_args(words).color == "gaussian-curvature"


def test_completion(call, tmp_path):
    pytest.importorskip("shtab")
    for shell in ("bash", "zsh", "fish"):
        status, out, _ = call("--completion", shell)
        assert status == 0
        for word in (*COMMANDS, "best-fit", "gaussian-curvature"):
            assert word in out
    script = tmp_path / "completion.bash"
    script.write_text(call("--completion", "bash")[1])
    program = (
        f"source {script}; COMP_WORDS=(isoembed embed --best); COMP_CWORD=2; _shtab_isoembed; "
        "echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "--best-fit"


def test_completion_needs_shtab(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["--completion", "zsh"]) == 2
    assert "pip install shtab" in capsys.readouterr().err
