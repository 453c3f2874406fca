"""Least-squares surfaces for edge lengths not realized exactly."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter


@dataclass(frozen=True, eq=False, repr=False)
class FittedSurface(Embedding):
    """Smooth surface whose edges come near to the lengths of a metric, but do not have them.

    Its `residuals` are the map of where it misses them.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages
        As of an `Embedding`.
    noise : float
        Root mean square of the errors that the lengths must have, over the mean edge length, if the surface
        they come from is as smooth as this one.
    weight : float
        Of the roughness against the squares of the residuals, in mean edge lengths.
    """

    _: KW_ONLY
    noise: float
    weight: float

    def _sentence(self) -> str:
        e = int(np.argmax(self.residuals))
        return (
            f"a least-squares surface that misses the lengths, by {self.residual_rms:.1e} of the mean "
            f"edge length (root mean square) and at most {self.residual:.1e}, at edge {e} "
            f"{self.metric.edges[e].tolist()}: its smoothness corresponds to length errors of about "
            f"{self.noise:.1e}"
        )

    def with_length_errors(self, errors: ArrayLike) -> Self:
        """Refuse: what a least-squares surface does with errors of the lengths is not what others do.

        Raises
        ------
        InvalidParameter
        """
        raise InvalidParameter("a best fit does not follow the errors of its lengths: it smooths them")

    @property
    def residual_rms(self) -> float:
        """Root mean square of `residuals`."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def is_answer(self) -> bool:
        """True: it was asked for, and claims no more than it is."""
        return True

    @property
    def status(self) -> str:
        """``"best fit"``."""
        return "best fit"

    @property
    def _reported(self) -> Mapping[str, Any]:
        """Entries of the report on the fit, under ``best_fit``."""
        found = {"noise": self.noise, "residual_rms": self.residual_rms, "weight": self.weight}
        return {"best_fit": found}
