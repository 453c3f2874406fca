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
    """Smooth surface with edge lengths close, but not equal, to those of a metric.

    Its `residuals` show the local deviations.

    Parameters
    ----------
    metric, vertices, method, tolerance, stages
        See `Embedding`.
    noise : float
        Root mean square error of the lengths, over the mean edge length, that would explain the residuals of
        a surface as smooth as this one.
    weight : float
        Weight of the roughness relative to the squared residuals, in mean edge lengths.
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
        """Raise InvalidParameter: a least-squares surface smooths the errors of its lengths.

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
        """True: a best fit need not converge to the lengths."""
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
