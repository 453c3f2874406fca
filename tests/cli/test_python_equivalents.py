"""Nothing that the command can do takes more than five lines of Python: both ways write the same."""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from isoembed.cli import main
from isoembed.cli.advice import in_options
from isoembed.relativity import KerrNewmanHorizon
from isoembed.smooth import GridMetric

SQUARE = {"rectangle": [1, 1]}
NET = {"dform": {"outlines": [SQUARE, SQUARE], "offset": 0.125}}

WAYS = {
    "surface ellipsoid --axes 3 2 1 --vertices 60 -o new.npz": """
from isoembed.gallery import Ellipsoid, triangulate
from isoembed import io, PolyhedralMetric
io.write_metric("new.npz", PolyhedralMetric.from_mesh(*triangulate(Ellipsoid((3, 2, 1)), 60)))
""",
    "inspect metric.npz --json > new.json": """
from isoembed.io import read_metric, write_report
from isoembed.metric.inspection import inspect
write_report("new.json", inspect(read_metric("metric.npz")).report)
""",
    "embed metric.npz --method paper --parameter Tsteps=2 -o new.ply --report new.json --html new.html": """
import isoembed, isoembed.plot as plot
film, method = plot.Film(), isoembed.Paper(Tsteps=2)
surface = isoembed.embed(isoembed.io.read_metric("metric.npz"), method=method, progress=film)
isoembed.io.write_surface("new.ply", surface), isoembed.io.write_report("new.json", isoembed.report(surface))
plot.write_page("new.html", surface, frames=film.frames(surface))
""",
    "glue net.json --metric new.npz -o new.obj": """
import isoembed, isoembed.io.net
net = isoembed.io.net.read_net("net.json")
isoembed.io.write_metric("new.npz", net.simplicial())
isoembed.io.write_surface("new.obj", isoembed.embed(net, method="alexandrov"))
""",
    "unfold body.ply -o new.svg --paper A3": """
import isoembed
surface = isoembed.io.read_surface("body.ply")
isoembed.papercraft.write_sheets("new.svg", isoembed.unfold(surface), paper="A3")
""",
    "unfold body.ply -o new.svg --size 300 --numbers --objective strips --keep 0-1": """
import isoembed
net = isoembed.unfold("body.ply", objective="strips", keep=[(0, 1)])
net.save("new.svg", size=300, numbers=True)
""",
    "unfold body.ply -o new.svg --size 300 --paper letter --objective pages": """
import isoembed
from isoembed.papercraft import fewest_pages
fewest_pages(isoembed.read("body.ply"), size=300, paper="letter").save("new.svg", size=300, paper="letter")
""",
    "nets platonic > new.txt": """
from pathlib import Path
from isoembed.gluing.classics import CLASSICS
from isoembed.gluing.folding import fold
Path("new.txt").write_text(f"{fold(CLASSICS['platonic'].make())}\\n")
""",
    "triangulate --spacetime kerr --spin 0.8 --surface horizon --vertices 60 -o new.npz": """
from isoembed import io, relativity, smooth
mesh = smooth.triangulate_metric(relativity.kerr_surface("horizon", spin=0.8).metric, 60)
io.write_atomically({"new.npz": io.metric_writer("new.npz", mesh.metric, directions=mesh.directions)})
""",
    "energy --spacetime kerr --spin 0.5 --surface horizon --vertices 60 --json -o new.npz > new.json": """
from isoembed import io, relativity
surface = relativity.embed_surface(relativity.kerr_surface("horizon", spin=0.5), vertices=60)
io.write_report("new.json", surface.report)
io.write_atomically({"new.npz": io.mesh_writer("new.npz", **surface.mesh(60))})
""",
    "energy isotropic --sphere 0 0 0 2 --vertices 60 --json > new.json": """
from isoembed import io, relativity
sphere, slice_ = relativity.StarSurface.sphere((0, 0, 0), 2.0), relativity.IsotropicSchwarzschild(1.0)
data = sphere.data(slice_, name="sphere of radius 2 about (0, 0, 0) in isotropic")
io.write_report("new.json", relativity.embed_surface(data, vertices=60).report)
""",
    "horizon --find --geometry isotropic --vertices 60 > new.txt": """
from pathlib import Path
from isoembed.relativity import IsotropicSchwarzschild, embed_series, energy_table, find_horizon
(found,) = embed_series([(None, find_horizon(IsotropicSchwarzschild(1.0)), None)], vertices=60)
report = found.report | {"name": "horizon in isotropic"}
Path("new.txt").write_text(f"{energy_table(report)}\\n")
""",
    "horizon one.npz two.npz --vertices 60 > new.txt": """
from pathlib import Path
from isoembed.relativity import embed_series, energy_table
moments = [(None, name, None) for name in ("one.npz", "two.npz")]
found = embed_series(moments, vertices=60)
Path("new.txt").write_text("".join(f"{energy_table(result.report)}\\n" for result in found))
""",
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a metric, a surface, a net and two horizons."""
    monkeypatch.chdir(tmp_path)
    main(["surface", "drum", "--vertices", "60", "-o", "metric.npz"])
    main(["surface", "ellipsoid", "--vertices", "20", "-o", "body.ply"])
    Path("net.json").write_text(json.dumps(NET))
    for name, spin in (("one", 0.5), ("two", 0.6)):
        metric = GridMetric.sampled(KerrNewmanHorizon(1.0, spin), 24, 1)
        np.savez(name, **{n: getattr(metric, n) for n in ("theta", "phi", "q_tt", "q_tp", "q_pp")})


def content(name):
    """What is in a file, but for times, with options in the place of arguments."""
    if name.endswith(".npz"):
        with np.load(name) as archive:
            return {key: archive[key].tolist() for key in archive}
    text = Path(name).read_text(errors="replace")
    if name.endswith(".html"):
        return re.sub(r'.*id="json".*|<td>[\d.]+</td>|.*application/json;base64.*', "", text)
    return in_options(re.sub(r'"seconds": [\d.e-]+', "", text))


@pytest.mark.slow
@pytest.mark.parametrize("command", WAYS)
def test_python_writes_what_the_command_writes(here, capfd, command):
    code = WAYS[command].strip()
    assert code.count("\n") < 5
    capfd.readouterr()
    arguments, _, printed = command.partition(" > ")
    before = set(os.listdir())
    assert main(arguments.split()) == 0
    if printed:
        Path(printed).write_text(capfd.readouterr().out)
    written = {name: content(name) for name in set(os.listdir()) - before}
    for name in written:
        Path(name).unlink()
    exec(code, {})
    assert written and written == {name: content(name) for name in set(os.listdir()) - before}
