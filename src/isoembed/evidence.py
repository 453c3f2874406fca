"""Kinds of evidence, proof or search, for statements of nonexistence or uniqueness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Evidence:
    """Evidence for a statement that something does not exist or is unique.

    Attributes
    ----------
    kind : {"proved", "searched"}
        "proved" where a theorem applies and its hypotheses hold by more than the error of the numbers that
        they were verified with; "searched" where a search ended without a result, which proves nothing.
    basis : str
        The theorem and the inequality verified, or the scope of the search.
    """

    kind: Literal["proved", "searched"]
    basis: str

    @property
    def report(self) -> dict[str, str]:
        """The entries ``evidence`` and ``basis`` of a report."""
        return {"evidence": self.kind, "basis": self.basis}
