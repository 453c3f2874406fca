"""All studies, one after the other, into a folder: a report, its figures and its numbers."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from isoembed.errors import NotEmbedded
from isoembed.io.files import FileError, Writer, check_output, write_atomically
from isoembed.plot.picture import check_drawable
from isoembed.studies import (
    accuracy,
    embedding_tree,
    ergosphere,
    inverted_vertex,
    mean_curvature,
    regularized_continuation,
    scaling,
    three_steps,
    triptychs,
)
from isoembed.studies.baselines import study as baselines
from isoembed.studies.report import TYPES, Made, page, rendered
from isoembed.studies.section import Section
from isoembed.version import __version__

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
    sizes : mapping
    """

    name: str
    make: Callable[..., Section]
    sizes: Mapping[str, Any]


@dataclass(frozen=True)
class Plan:
    """What is made.

    Attributes
    ----------
    name : str
    studies : tuple of Study
        In the order of the report.
    """

    name: str
    studies: tuple[Study, ...]


@dataclass(frozen=True)
class Outcome:
    """What came of a plan.

    Attributes
    ----------
    report : Path
    failures : tuple of str
        Sections that could not be made, and why.
    """

    report: Path
    failures: tuple[str, ...] = field(default=())


FULL = Plan(
    "full",
    (
        Study("three-steps", three_steps.study, {"vertices": 160}),
        Study(
            "embedding-tree",
            embedding_tree.study,
            {"shown": 400, "sizes": (100, 200, 400, 800, 1600, 3226, 6400)},
        ),
        Study("inverted-vertex", inverted_vertex.study, {"vertices": 60}),
        Study(
            "guided-pull-back",
            regularized_continuation.study,
            {"cases": (("ellipsoid", 1600, 20), ("drum", 1600, 10)), "path_vertices": 400},
        ),
        Study("triptychs", triptychs.study, {"ellipsoid": 3226, "drum": 3246, "ergosphere": 3246}),
        Study("accuracy", accuracy.study, {"vertices": 3226}),
        Study("mean-curvature", mean_curvature.study, {"sizes": (400, 800, 1600, 3200, 6400, 12800)}),
        Study(
            "scaling",
            scaling.study,
            {
                "sizes": (400, 800, 1600, 3226, 6400, 12800),
                "flow_sizes": (100, 200, 400),
                "step_sizes": (400, 800, 1600, 3226, 6400),
            },
        ),
        Study(
            "ergosphere",
            ergosphere.study,
            {"vertices": 1600, "epsilons": (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 1.3, 2.0)},
        ),
        Study("baselines", baselines.study, {"vertices": 800, "degree": 16, "steps": 4, "seeds": 5}),
    ),
)

QUICK = Plan(
    "quick",
    (
        Study("three-steps", three_steps.study, {"vertices": 160}),
        Study("embedding-tree", embedding_tree.study, {"shown": 400, "sizes": (100, 200, 400)}),
        Study("inverted-vertex", inverted_vertex.study, {"vertices": 60}),
        Study(
            "guided-pull-back",
            regularized_continuation.study,
            {"cases": (("ellipsoid", 400, 5), ("drum", 200, 10)), "path_vertices": 100},
        ),
        Study("triptychs", triptychs.study, {"ellipsoid": 600, "drum": 600, "ergosphere": 800}),
        Study("accuracy", accuracy.study, {"vertices": 400}),
        Study("mean-curvature", mean_curvature.study, {"sizes": (200, 400, 800, 1600)}),
        Study(
            "scaling",
            scaling.study,
            {"sizes": (200, 400, 800), "flow_sizes": (100, 200), "step_sizes": (400, 800, 1600)},
        ),
        Study("ergosphere", ergosphere.study, {"vertices": 300, "epsilons": (0.1, 0.3, 1.3)}),
        Study("baselines", baselines.study, {"vertices": 200, "degree": 8, "steps": 4, "seeds": 2}),
    ),
)


def reproduce(plan: Plan, folder: Path, tell: Callable[[str], None]) -> Outcome:
    """Make every section of a plan, and write the report, the figures and the numbers.

    Parameters
    ----------
    plan : Plan
    folder : Path
        Made if it is not there.
    tell : callable
        Receives a line when a section begins and one when it is done.

    Returns
    -------
    Outcome
        A section in which a surface could not be embedded is replaced by the reason.

    Raises
    ------
    FileError
        The folder cannot be made or written, or matplotlib is not installed.
    """
    check_drawable()
    _prepare(folder)
    made, failures = [], []
    for k, study in enumerate(plan.studies):
        tell(f"{k + 1}/{len(plan.studies)} {study.name} ...")
        began = perf_counter()
        try:
            with threadpool_limits(1):  # for matrices this small, threads spend their time on each other
                section = study.make(**study.sizes)
        except NotEmbedded as error:
            failures.append(f"{study.name}: {error}")
            section = Section(study.name, (f"This section could not be made: {error}",))
        images = {each.name: rendered(each.figure) for each in section.figures}
        made.append(Made(study.name, section, images, perf_counter() - began))
        tell(f"{k + 1}/{len(plan.studies)} {study.name}: {made[-1].seconds:.1f} s")
    writers: dict[Path, Writer] = {
        folder / FIGURES / f"{name}{image.ending}": _bytes(image.data)
        for one in made
        for name, image in one.images.items()
    }
    numbers = json.dumps(_numbers(made, plan), indent=2, allow_nan=False) + "\n"
    writers[folder / NUMBERS] = _bytes(numbers.encode())
    writers[folder / REPORT] = _bytes(page(made, plan.name).encode())
    write_atomically(writers)
    for one in made:
        for name, image in one.images.items():
            for ending in TYPES.keys() - {image.ending}:  # what an earlier run may have left
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


def _bytes(data: bytes) -> Writer:
    def write(path: Path) -> None:
        path.write_bytes(data)

    return write


def _numbers(made: Sequence[Made], plan: Plan) -> dict[str, Any]:
    return {
        "version": __version__,
        "plan": plan.name,
        "sections": {
            one.name: {
                "title": one.section.title,
                "sizes": _plain(study.sizes),
                "seconds": round(one.seconds, 3),
                "comparisons": [vars(comparison) for comparison in one.section.comparisons],
                "numbers": _plain(one.section.numbers),
            }
            for one, study in zip(made, plan.studies, strict=True)
        },
    }


def _plain(value: Any) -> Any:
    """What JSON can hold: a number that is not finite is null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
