"""Progress of a computation: its stages, snapshots, the time left, checkpoints and what they belong to.

`bar` shows it live.
"""

from isoembed.progress.live import bar

__all__ = ["bar"]
