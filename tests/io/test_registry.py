"""Formats of other packages, as they are installed: what they may not replace, and when they are loaded."""

import os
import subprocess
import sys

ENTRIES = """[isoembed.formats]
.bad = no_such_module:FORMAT
.json = no_such_module:FORMAT
.npz = no_such_module:FORMAT
dotless = no_such_module:FORMAT
"""
CODE = """
import sys
from isoembed.cli import main
from isoembed.io import SURFACE_ENDINGS, check_output
from isoembed.io.registry import FORMATS

assert SURFACE_ENDINGS[-2:] == (".vtp", ".bad"), SURFACE_ENDINGS
assert FORMATS[".json"].holds_metrics and FORMATS[".npz"].holds_metrics
check_output("a.npz", SURFACE_ENDINGS)
ellipsoid = ["surface", "ellipsoid", "--axes", "1.5", "1.2", "1", "--vertices", "100", "-o"]
commands = [
    [*ellipsoid, "a.npz"],
    [*ellipsoid, "a.bad"],
    ["embed", "missing.npz", "-o", "a.bad"],
    ["energy", "missing.npz", "-o", "a.bad"],
]
print([main(command) for command in commands])
"""


def test_formats_of_installed_packages(tmp_path):
    about = tmp_path / "bad-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: bad\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(ENTRIES)
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[0, 2, 2, 2]", done.stderr
    sentences = done.stderr.splitlines()[-3:]
    expected = "the format '.bad' cannot be loaded from no_such_module:FORMAT"
    assert all(expected in sentence for sentence in sentences), sentences
