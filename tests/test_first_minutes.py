"""What a newcomer types, from the README, from habit and with typos, and what is answered."""

import shlex
import shutil

import numpy as np
import pytest

import isoembed
import zoo
from isoembed.cli import main

DONE, WRONG, NONE = 0, 2, 3

COMMANDS = [
    # What is shown first.
    ("isoembed", WRONG, "Five things to try:"),
    ("isoembed --version", DONE, f"isoembed {isoembed.__version__}"),
    ("isoembed -h", DONE, "usage: isoembed"),
    ("isoembed help unfold", WRONG, "unknown command 'help': of a command, isoembed COMMAND --help"),
    ("isoembed metric.npz", WRONG, "isoembed embed metric.npz"),
    ("isoembed embed --help", DONE, "examples:"),
    # The five things.
    ("isoembed surface ellipsoid --axes 3 2 1 --vertices 50 -o new.npz", DONE, "new.npz written, "),
    ("isoembed embed metric.npz -o new.ply", DONE, "certified: a realization of these lengths is within"),
    ("isoembed inspect cube.obj", DONE, "a polyhedral metric on the sphere"),
    ("isoembed unfold cube.obj -o new.svg", DONE, "1 sheet, 7 pairs of sides, 5 folds"),
    ("isoembed view cube.obj -o new.html", DONE, "new.html written, "),
    # Habits.
    ("isoembed embed metric.npz", DONE, "int H dA"),
    ("isoembed embed metric.npz new.ply", WRONG, "did you mean -o new.ply?"),
    ("isoembed unfold cube.obj new.pdf", WRONG, "required: -o/--output; did you mean -o new.pdf?"),
    ("isoembed unfold cube.obj --size 20.5", WRONG, "required: -o/--output (see"),
    ("isoembed glue net.json new.ply", WRONG, "unrecognized arguments: new.ply; did you mean -o new.ply?"),
    ("isoembed nets cube", WRONG, "'cube' is one of the nets of 'platonic'"),
    ("isoembed embed metric.npz -o new.png", WRONG, "did you mean --picture new.png?"),
    ("isoembed embed metric.npz -o no/new.ply", WRONG, "there is no folder"),
    ("isoembed view cube.obj -o new.svg --color 'Gaussian curvature'", DONE, "new.svg written, "),
    (
        "isoembed embed net.svg -o new.ply",
        WRONG,
        "glue it first, with 'isoembed glue net.svg -o surface.ply'",
    ),
    ("isoembed embed part.step -o new.ply", WRONG, "open it with FreeCAD, and export it as .stl or .obj"),
    ("isoembed embed net.json -o new.ply", WRONG, "'isoembed glue net.json -o surface.ply'"),
    ("isoembed glue metric.npz -o new.ply", WRONG, "'isoembed embed metric.npz -o surface.ply'"),
    ("isoembed unfold metric.npz -o new.svg", WRONG, "'isoembed embed metric.npz -o surface.ply'"),
    ("isoembed glue net.json -o new.ply", DONE, "new.ply written, "),
    ("isoembed nets", DONE, "latin-cross"),
    (
        "isoembed energy --spacetime kerr --spin 0.9 --surface horizon",
        NONE,
        "isoembed: try: --band FILE, which writes the band that embeds",
    ),
    # Typos.
    ("isoembed emebd metric.npz", WRONG, "did you mean 'embed'?"),
    ("isoembed embed metrics.npz", WRONG, "did you mean 'metric.npz'?"),
    ("isoembed unfold cube.ojb -o new.pdf", WRONG, "there is no file cube.ojb; did you mean 'cube.obj'?"),
    ("isoembed unfold cube.obj -o new.pfd", WRONG, "; did you mean '.pdf'?"),
    ("isoembed unfold part.txt -o new.pdf", WRONG, ".glb .gltf\n"),
    ("isoembed view cube.obj --color gausssian", WRONG, "did you mean 'gaussian-curvature'?"),
    ("isoembed embed metric.npz --bestfit", WRONG, "did you mean '--best-fit'?"),
    ("isoembed surface elipsoid --vertices 50 -o new.npz", WRONG, "did you mean 'ellipsoid'?"),
    ("isoembed energy --spacetime ker --surface horizon", WRONG, "did you mean 'kerr'?"),
    ("isoembed embed metric.npz --tolerance tiny", WRONG, "'tiny' is not a number"),
]

PYTHON = [
    ("isoembed.embed('metric.npz').converged", True),
    ("isoembed.embed((vertices, faces)).volume > 0", True),
    ("isoembed.embed([vertices, faces]).edges.shape", (30, 2)),
    ("isoembed.embed(isoembed.glue('net.json')).volume", pytest.approx(1, rel=1e-9)),
    ("isoembed.embed('net.json').volume", pytest.approx(1, rel=1e-9)),
    ("isoembed.read('cube.obj').save('new.stl')", None),
    ("isoembed.unfold('cube.obj').save('new.svg')", None),
    ("isoembed.io.read_metric('metric.npz').lengths.shape", (144,)),
    ("isoembed.read('cube.obj').plot(color='gaussian_curvature') is not None", True),
    ("isoembed.embed(vertices)", "give PolyhedralMetric.*or a mesh, such as .vertices, faces"),
    ("isoembed.embed('metric.npz', method='alexandrof')", "did you mean 'alexandrov'"),
    ("isoembed.read('metrics.npz')", "did you mean 'metric.npz'"),
    ("isoembed.unfold(isoembed.read('metric.npz'))", "embed it first"),
    ("isoembed.read('cube.obj').save('new.jpg')", "not one of .*ply .*png"),
    ("isoembed.read('cube.obj').plot(color='mean curvatur')", "did you mean 'mean-curvature'"),
]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with a metric, a mesh and a net."""
    made = tmp_path_factory.mktemp("files")
    line = "surface ellipsoid --axes 3 2 1 --vertices 50 --quiet -o"
    assert main([*shlex.split(line), str(made / "metric.npz")]) == 0
    isoembed.embed(zoo.cube()).save(made / "cube.obj")
    isoembed.unfold(made / "cube.obj").save(made / "net.json")
    (made / "part.step").write_text("ISO-10303-21;")
    (made / "part.txt").write_text("a part")
    return made


@pytest.fixture
def folder(files, tmp_path, monkeypatch):
    """A copy, in which one works."""
    shutil.copytree(files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("line", "status", "said"), COMMANDS, ids=[line for line, *_ in COMMANDS])
def test_command_lines(line, status, said, folder, capsys):
    assert main(shlex.split(line)[1:]) == status
    out, err = capsys.readouterr()
    assert said in out + err
    reasons = [said for said in err.splitlines() if not said.startswith("isoembed: try: ")]
    assert len(reasons) <= 1


@pytest.mark.parametrize(("line", "answer"), PYTHON, ids=[line for line, _ in PYTHON])
def test_python(line, answer, folder):
    vertices, faces = zoo.icosphere(0)
    names = {"isoembed": isoembed, "vertices": np.asarray(vertices), "faces": faces}
    if isinstance(answer, str):
        with pytest.raises(ValueError, match=answer):
            eval(line, names)
    else:
        assert eval(line, names) == answer
