"""Progress of a computation: stages, snapshots, remaining time, checkpoints.

`bar` displays it live.
"""

from isoembed.progress.live import bar

__all__ = ["bar"]
