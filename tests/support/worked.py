"""The stages of a computation without those in which functions were compiled, on a first run."""

from isoembed.progress.stages import COMPILATION


def worked(stages):
    """Those stages, of an embedding or a report."""
    return [s for s in stages if (s["name"] if isinstance(s, dict) else s.name) != COMPILATION]
