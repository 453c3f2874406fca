"""Batch runs: many tasks on all cores or a cluster, with stored results."""

from isoembed.runs.chunk import Outcome, Wish
from isoembed.runs.result import Result
from isoembed.runs.run import Shard, run
from isoembed.runs.store import Store
from isoembed.runs.task import Task
from isoembed.runs.workers import Workers

__all__ = ["Outcome", "Result", "Shard", "Store", "Task", "Wish", "Workers", "run"]
