"""Check what is released: build it, look into it, install it elsewhere, run the pages with it.

    python release/check.py [--output FOLDER]

needs git, a package index, and ``pip install -e '.[release]'``.  What git knows is built, with the links of
README.md made whole.  Two fresh environments, without extras and with those of pictures and HDF5, take the
wheel; outside of the clone README.md and pages of docs/ run there.  Every other Python from 3.11 to 3.14 that
is installed takes it without extras, and runs README.md.  The time from the beginning of ``pip install`` to
the first picture is printed.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
import zipfile
from pathlib import Path, PurePosixPath

from readme import relative_links, whole

ROOT = Path(__file__).resolve().parents[1]
RUNNER = ROOT / "tests" / "support" / "page_blocks.py"
PAGES = ["README.md", "docs/index.md", "docs/getting-started.md"]
EXTRAS = "plot,hdf5"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
FIRST = ("surface ellipsoid --axes 3 2 1 --vertices 400 -o m.npz", "embed m.npz --html first.html")
"""Commands that make the first picture."""


def run(*command: object, folder: Path = ROOT) -> str:
    """Run a command; return what it printed, or end with all that it said."""
    done = subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"failed: {' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def compare(what: str, found: set[str], expected: set[str]) -> None:
    """End with a sentence if these are not the files that were expected."""
    if missing := sorted(expected - found):
        sys.exit(f"the {what} lacks {len(missing)} files, the first is {missing[0]}")
    if more := sorted(found - expected):
        sys.exit(f"the {what} has {len(more)} files that do not belong there, the first is {more[0]}")
    print(f"{what}: {len(found)} files, those of the repository")


def check_contents(wheel: Path, sdist: Path) -> None:
    """The sdist has what git knows, and the wheel what git knows of the package and its compiled modules."""
    tracked = set(run("git", "ls-files").splitlines())
    with tarfile.open(sdist) as archive:
        members = [PurePosixPath(member.name) for member in archive if not member.isdir()]
    names = {"/".join(path.parts[1:]) for path in members}
    made = {name for name in names if ".egg-info/" in name} | {"PKG-INFO", "setup.cfg"}
    compare("sdist", names, tracked | made)
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    package = {name.removeprefix("src/") for name in tracked if name.startswith("src/")}
    compiled = {
        name.removesuffix(".py")
        for name in package
        if name.endswith(".py") and (ROOT / "src" / name).read_bytes().startswith(b"# cython:")
    }
    libraries = {name for name in names if name.endswith((".so", ".pyd"))}
    compare("compiled modules", {name.split(".")[0] for name in libraries}, compiled)
    compare("wheel", names - libraries, package)
    if "-cp311-abi3-" not in wheel.name:
        sys.exit(f"{wheel.name} is not for all Pythons from 3.11 on")
    for name in ("isoembed/py.typed", "isoembed/__init__.pyi"):
        if name not in names:
            sys.exit(f"the wheel lacks {name}")


def copy_of_the_sources(folder: Path) -> Path:
    """Copy what git knows, with whole links in README.md if the repository has an address."""
    for name in run("git", "ls-files").splitlines():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, target)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    readme = folder / "README.md"
    text = readme.read_text(encoding="utf-8")
    if repository := project["urls"].get("Repository"):
        version = re.search(r'"(.+)"', (ROOT / "src/isoembed/version.py").read_text(encoding="utf-8"))[1]
        readme.write_text(whole(text, repository, version), encoding="utf-8")
    else:
        count = len(relative_links(text))
        print(
            f"README.md: {count} links lead nowhere on an index: [project.urls] has no Repository", flush=True
        )
    return folder


def interpreter(version: str) -> str | None:
    """A Python of this version that can make environments, on the path or of pyenv; None without."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for python in (f"python{version}", *map(str, kept.glob(f"{version}.*/bin/python"))):
        asked = [python, "-c", "import venv, ensurepip, sys; print('%d.%d' % sys.version_info[:2])"]
        try:
            done = subprocess.run(asked, capture_output=True, text=True)
        except FileNotFoundError:
            continue
        if done.stdout.strip() == version:
            return python
    return None


def environment(folder: Path, python: str = sys.executable) -> Path:
    """Make an environment; return its folder of programs."""
    run(python, "-m", "venv", folder)
    return folder / ("Scripts" if sys.platform == "win32" else "bin")


def check_installed(
    requirement: str, programs: Path, folder: Path, pages: list[str] = PAGES
) -> tuple[float, float]:
    """Install into an environment, make a picture, run the pages; return the seconds of the first two."""
    folder.mkdir()
    begun = time.perf_counter()
    run(programs / "python", "-m", "pip", "install", "--quiet", requirement, folder=folder)
    installed = time.perf_counter()
    for command in FIRST:
        run(programs / "isoembed", *command.split(), folder=folder)
    if not (folder / "first.html").stat().st_size:
        sys.exit("the first picture is empty")
    seen = time.perf_counter()
    print(run(programs / "python", "-P", RUNNER, *(ROOT / page for page in pages), folder=folder), end="")
    return installed - begun, seen - installed


def main() -> None:
    """Check everything."""
    parser = argparse.ArgumentParser(description="Check what is released.")
    parser.add_argument("--output", type=Path, help="keep the wheel and the sdist in this new folder")
    output = parser.parse_args().output
    with tempfile.TemporaryDirectory() as temporary:
        place = Path(temporary)
        built = place / "dist" if output is None else output.resolve()
        sources = copy_of_the_sources(place / "sources")
        run(sys.executable, "-m", "build", "--outdir", built, sources)
        (wheel,), (sdist,) = built.glob("*.whl"), built.glob("*.tar.gz")
        run(sys.executable, "-m", "twine", "check", "--strict", wheel, sdist)
        check_contents(wheel, sdist)
        for name, requirement in (("without extras", str(wheel)), (f"with [{EXTRAS}]", f"{wheel}[{EXTRAS}]")):
            print(f"installed {name}:", flush=True)
            programs = environment(place / name)
            seconds, more = check_installed(requirement, programs, place / f"pages {name}")
            print(f"pip install took {seconds:.0f} s, and the first picture {more:.0f} s more", flush=True)
        everywhere = wheel if re.search("-py3-none-|-abi3-", wheel.name) else sdist
        for version in PYTHONS:
            if version == f"{sys.version_info[0]}.{sys.version_info[1]}":
                continue
            if (python := interpreter(version)) is None:
                print(f"NOT TESTED: Python {version} is not here", flush=True)
                continue
            print(f"installed with Python {version}:", flush=True)
            programs = environment(place / version, python)
            check_installed(str(everywhere), programs, place / f"pages {version}", PAGES[:1])


if __name__ == "__main__":
    main()
