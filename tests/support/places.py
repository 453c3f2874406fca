"""Where the project is, and the folder of cases that may stand beside it."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared"
SUPPORT = ROOT / "tests" / "support"
