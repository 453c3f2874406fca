"""Every benchmark runs to its end, at the smallest size that it has."""

import subprocess
import sys
from pathlib import Path

import pytest

from places import ROOT

SMALLEST = {
    "alexandrov": "--sizes 100 --sweep 1",
    "ambiguity": "--sizes 100 --bodies kerr saddle --seeds 1",
    "bent": "--sizes 300 --bodies peanut --kinds regular",
    "certificates": "--sizes 100",
    "cold_start": "--only surface",
    "convex_sweep": "--seeds 1",
    "damaged_files": "--count 20",
    "dents": "--vertices 200 --dimples 1 --every 40",
    "common_horizons": "--pairs 1 --groups 0 --ratios 1",
    "deviation": "--size 60 --noises 3",
    "fuzz": "--count 1 --families stars hyperbolic",
    "hyperbolic_discs": "--radii 1 --waves 2 --vertices 40",
    "honesty": "--only units",
    "horizon_sequence": "--count 2 --only kerr",
    "house": f"{ROOT / 'src' / 'isoembed'}",
    "linalg": "3000",
    "makers": "--only Platonic --sizes 100 --files svg",
    "mergers": "--only kerr",
    "million": "--sizes 500 --only sizes",
    "peers": "--sizes 100 --seeds 1",
    "realizations": "--gallery 60",
    "rounded": "--families domes --digits 3 --questions rounded --seeds 1 --most 50",
    "rounded_solids": "--families uniform --decimals 7",
    "relativity": "--only degree",
    "series": "--count 16 --vertices 40",
    "shallow_caps": "--count 1",
    "sharp_edges": "--bodies box --blunders 50",
    "sheets": "--count 1 --sizes 60 120",
    "smooth_space_forms": "--only bodies --bodies 1",
    "space_forms": "--seeds 1 --sizes 60",
    "stages": "--sizes 100 200",
    "stars": "--count 4",
    "threads": "--vertices 300 --threads 2",
    "unfold": "--hulls 2",
    "wang_yau": "--only spheres",
}
SCRIPTS = {
    path.stem for path in (ROOT / "benchmarks").glob("*.py") if '__name__ == "__main__"' in path.read_text()
}


def test_each_has_a_smallest_size():
    assert set(SMALLEST) == SCRIPTS


@pytest.mark.slow
@pytest.mark.parametrize("name", SMALLEST)
def test_it_runs_to_its_end(name, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent))  # no compiler: peers.py measures ours alone
    script = ROOT / "benchmarks" / f"{name}.py"
    done = subprocess.run(
        [sys.executable, script, *SMALLEST[name].split()], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout
