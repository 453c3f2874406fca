"""Whoever waits at a terminal is told that the command is at work; who does not, is not."""

import io
import sys
import threading

import pytest

from isoembed.cli import main, waiting
from isoembed.cli.waiting import ERASED, Waiting


class Terminal(io.StringIO):
    """A terminal that tells when something was written to it."""

    def __init__(self):
        super().__init__()
        self.written = threading.Event()

    def isatty(self):
        return True

    def write(self, text):
        count = super().write(text)
        self.written.set()
        return count


@pytest.fixture
def attached(monkeypatch):
    """Attach standard error to a terminal, and return it."""

    def attached():
        shown = Terminal()
        monkeypatch.setattr(sys, "stderr", shown)
        monkeypatch.setattr(waiting, "PATIENCE", 0.0)
        return shown

    return attached


def test_the_line_is_shown_and_taken_away(attached):
    terminal = attached()
    with waiting.waiting(quiet=False):
        assert terminal.written.wait(10)
    assert terminal.getvalue().startswith(f"{ERASED}isoembed: working, 0 s (Ctrl-C stops)")
    assert terminal.getvalue().endswith(ERASED)
    assert sys.stderr is terminal


def test_what_is_printed_takes_its_place(attached):
    terminal = attached()
    with waiting.waiting(quiet=False):
        assert terminal.written.wait(10)
        print("answer", file=sys.stderr)
    assert f"{ERASED}answer\n" in terminal.getvalue()


def test_it_is_held_where_a_command_shows_more(attached, monkeypatch):
    terminal = attached()
    line = Waiting(terminal)
    monkeypatch.setattr(waiting, "PERIOD", 1e-3)
    with line.suspended():
        thread = threading.Thread(target=line.run)
        thread.start()
        assert not terminal.written.wait(0.05)
    assert terminal.written.wait(10)
    line.end()
    thread.join(10)
    assert not thread.is_alive()


@pytest.mark.parametrize(("quiet", "tty"), [(True, True), (False, False)])
def test_nothing_is_shown(quiet, tty, attached, monkeypatch):
    terminal = attached()
    monkeypatch.setattr(Terminal, "isatty", lambda _: tty)
    with waiting.waiting(quiet=quiet) as line:
        assert line is None
    assert terminal.getvalue() == ""


@pytest.mark.parametrize("command", [["nets", "platonic"], ["surface", "--list"]])
def test_commands_on_a_terminal_leave_no_line_behind(command, attached, monkeypatch):
    terminal = attached()
    assert main(command) == 0
    assert terminal.getvalue() == "" or terminal.getvalue().endswith(ERASED)
