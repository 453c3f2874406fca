"""Strict JSON, in which NaN and infinity do not exist."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Convert to JSON types: arrays to lists, and numbers that are not finite to None."""
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def strict_json(document: Any, indent: int | None = None) -> str:
    """Text of a document in JSON, with null in place of a number that is not finite."""
    return json.dumps(plain(document), indent=indent, allow_nan=False)
