"""All studies one after the other, and the folder that they go into: a report, figures and numbers."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from threadpoolctl import threadpool_limits

from isoembed import NotEmbedded, __version__
from isoembed.io import FileError, check_output, report_writer, write_atomically
from reproduction import (
    accuracy,
    bowen_york,
    constant_radius,
    embedding_tree,
    equivalent,
    ergosphere,
    flexible,
    head_on,
    horizon_mass,
    hyperbolic_torus,
    inverted_vertex,
    mean_curvature,
    regularized_continuation,
    scaling,
    three_steps,
    triptychs,
    weyl_path,
)
from reproduction.baselines import study as baselines
from reproduction.report import TYPES, Made, page, rendered
from reproduction.section import Section

REPORT, NUMBERS, FIGURES = "report.html", "numbers.json", "figures"


@dataclass(frozen=True)
class Study:
    """A study with the sizes that it is made at.

    Attributes
    ----------
    name : str
        For links and ``numbers.json``.
    make : callable
        Takes the sizes as keywords and returns a Section.
    full, quick : mapping
        The sizes of the paper, and small ones.
    """

    name: str
    make: Callable[..., Section]
    full: Mapping[str, Any]
    quick: Mapping[str, Any]


@dataclass(frozen=True)
class Outcome:
    """The report, and the sections that could not be made with the reasons."""

    report: Path
    failures: tuple[str, ...] = ()


STUDIES = (
    Study("three-steps", three_steps.study, {"vertices": 160}, {"vertices": 160}),
    Study(
        "embedding-tree",
        embedding_tree.study,
        full={"shown": 400, "sizes": (100, 200, 400, 800, 1600, 3226, 6400)},
        quick={"shown": 400, "sizes": (100, 200, 400)},
    ),
    Study("inverted-vertex", inverted_vertex.study, {"vertices": 60}, {"vertices": 60}),
    Study(
        "guided-pull-back",
        regularized_continuation.study,
        full={"cases": (("ellipsoid", 1600, 20), ("drum", 1600, 10)), "path_vertices": 400},
        quick={"cases": (("ellipsoid", 400, 5), ("drum", 200, 10)), "path_vertices": 100},
    ),
    Study(
        "triptychs",
        triptychs.study,
        full={"ellipsoid": 3226, "drum": 3246, "ergosphere": 3246},
        quick={"ellipsoid": 600, "drum": 600, "ergosphere": 800},
    ),
    Study("accuracy", accuracy.study, {"vertices": 3226}, {"vertices": 400}),
    Study(
        "mean-curvature",
        mean_curvature.study,
        full={"sizes": (400, 800, 1600, 3200, 6400, 12800)},
        quick={"sizes": (200, 400, 800, 1600)},
    ),
    Study(
        "scaling",
        scaling.study,
        full={
            "sizes": (400, 800, 1600, 3226, 6400, 12800),
            "flow_sizes": (100, 200, 400),
            "step_sizes": (400, 800, 1600, 3226, 6400),
        },
        quick={"sizes": (200, 400, 800), "flow_sizes": (100, 200), "step_sizes": (400, 800, 1600)},
    ),
    Study(
        "ergosphere",
        ergosphere.study,
        full={"vertices": 1600, "epsilons": (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 1.3, 2.0)},
        quick={"vertices": 300, "epsilons": (0.1, 0.3, 1.3)},
    ),
    Study(
        "baselines",
        baselines.study,
        full={"vertices": 800, "degree": 16, "steps": 4, "seeds": 5},
        quick={"vertices": 200, "degree": 8, "steps": 4, "seeds": 2},
    ),
    Study(
        "equivalent",
        equivalent.study,
        full={"sizes": (100, 200), "seeds": (None, 1, 2), "parallel": 400, "batch": 8},
        quick={"sizes": (100,), "seeds": (1,), "parallel": 200, "batch": 4},
    ),
    Study(
        "horizon-mass",
        horizon_mass.study,
        full={"spins": (0.3, 0.6, 0.8, 0.9, 0.95, 0.99, 1.0), "charged": 8, "vertices": 4000},
        quick={"spins": (0.5, 0.95), "charged": 3, "vertices": 400},
    ),
    Study(
        "constant-radius",
        constant_radius.study,
        full={"spins": 21, "vertices": 2000, "radii": (1.7, 2.2, 3.0, 5.0, 10.0, 30.0, 100.0)},
        quick={"spins": 5, "vertices": 300, "radii": (2.0, 5.0)},
    ),
    Study(
        "weyl-path",
        weyl_path.study,
        full={"sizes": (0.7, 0.5, 0.35, 0.25, 0.18, 0.12), "vertices": 1407, "images": 24},
        quick={"sizes": (0.7, 0.5), "vertices": 1407, "images": 4},
    ),
    Study(
        "head-on",
        head_on.study,
        full={
            "separate": (6.0, 4.0, 3.0, 2.0, 1.5, 1.0),
            "common": (0.766, 0.76, 0.74, 0.7, 0.65, 0.6, 0.5, 0.4),
            "inner": True,
            "expansions": (0.6, 0.5, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4),
        },
        quick={"separate": (2.0, 1.0), "common": (0.7, 0.5), "inner": False, "expansions": (0.1, 1e-3)},
    ),
    Study(
        "bowen-york",
        bowen_york.study,
        full={
            "distances": (6.0, 4.0, 3.0, 2.0, 1.5, 1.0, 0.8, 0.76, 0.7, 0.6, 0.5, 0.4),
            "expansions": (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4),
            "momenta": (-0.2, 0.2, 0.5, 1.0),
        },
        quick={"distances": (2.0, 0.7), "expansions": (0.1, 1e-3), "momenta": (0.5,)},
    ),
    Study(
        "flexible",
        flexible.study,
        full={"steps": 60, "stacked": 5, "starts": 60},
        quick={"steps": 20, "stacked": 2, "starts": 5},
    ),
    Study("hyperbolic-torus", hyperbolic_torus.study, full={}, quick={}),
)
"""In the order of the report."""


def reproduce(
    studies: Sequence[Study], folder: Path, tell: Callable[[str], None], *, quick: bool = False
) -> Outcome:
    """Make every section, and write the report, the figures and the numbers.

    Parameters
    ----------
    studies : sequence of Study
    folder : Path
        Made if it is not there.
    tell : callable
        Receives a line when a section begins and one when it is done.
    quick : bool
        Small sizes.

    Returns
    -------
    Outcome
        A section in which a surface could not be embedded is replaced by the reason.

    Raises
    ------
    FileError
        The folder cannot be made or written.
    """
    _prepare(folder)
    made, failures = [], []
    for k, study in enumerate(studies):
        tell(f"{k + 1}/{len(studies)} {study.name} ...")
        began = perf_counter()
        sizes = study.quick if quick else study.full
        try:
            with threadpool_limits(1):  # for matrices this small, threads spend their time on each other
                section = study.make(**sizes)
        except NotEmbedded as error:
            failures.append(f"{study.name}: {error}")
            section = Section(study.name, (f"This section could not be made: {error}",))
        images = {each.name: rendered(each.figure) for each in section.figures}
        made.append(Made(study.name, sizes, section, images, perf_counter() - began))
        tell(f"{k + 1}/{len(studies)} {study.name}: {made[-1].seconds:.1f} s")
    plan = "quick" if quick else "full"
    files = {
        f"{FIGURES}/{name}{image.ending}": image.data for one in made for name, image in one.images.items()
    }
    files[REPORT] = page(made, plan).encode()
    writers = {folder / name: _bytes(data) for name, data in files.items()}
    write_atomically({**writers, folder / NUMBERS: report_writer(_numbers(made, plan))})
    for one in made:
        for name in one.images:
            for ending in TYPES:
                if f"{FIGURES}/{name}{ending}" not in files:  # what an earlier run may have left
                    (folder / FIGURES / f"{name}{ending}").unlink(missing_ok=True)
    return Outcome(folder / REPORT, tuple(failures))


def _prepare(folder: Path) -> None:
    """Make the folders, or say why not before anything is computed."""
    for each in (folder, folder / FIGURES):
        try:
            each.mkdir(parents=True, exist_ok=True)
        except FileExistsError:
            raise FileError(f"cannot write {each}: it is not a folder") from None
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise FileError(f"cannot make the folder {each}: {reason}") from None
        if not os.access(each, os.W_OK | os.X_OK):
            raise FileError(f"cannot write {each}: no permission to write in it")
    for name in (REPORT, NUMBERS):
        check_output(folder / name, {Path(name).suffix})


def _bytes(data: bytes) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.write_bytes(data)

    return write


def _numbers(made: Sequence[Made], plan: str) -> dict[str, Any]:
    return {
        "version": __version__,
        "plan": plan,
        "sections": {
            one.name: {
                "title": one.section.title,
                "sizes": one.sizes,
                "seconds": round(one.seconds, 3),
                "comparisons": [vars(comparison) for comparison in one.section.comparisons],
                "numbers": one.section.numbers,
            }
            for one in made
        },
    }
