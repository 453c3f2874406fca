"""A method that counts down to the answer: it keeps every step, and can be stopped at one."""

import os
import signal
import time
from dataclasses import dataclass
from typing import ClassVar

import zoo
from isoembed.embedding.embedding import Embedding
from isoembed.method import Method
from isoembed.metric.polyhedral import PolyhedralMetric

STAGE = "counting"
HOME = "counting:Counting"  # for METHODS


@dataclass(frozen=True)
class Counting(Method):
    """Embeds `zoo.icosphere(1)`: the larger copies of it that it passes through are nothing but copies.

    A run that does not go on from another one gets the `signals` when the step `stop` is kept, and, if
    `wait`, then stays until it is told to go.  Without `keeps` it keeps nothing.
    """

    steps: int = 5
    stop: int = -1
    number: int = int(signal.SIGINT)
    wait: bool = False
    keeps: bool = True

    name: ClassVar[str] = "counting"

    def run(self, metric, tolerance, log):
        log.expect({STAGE: 1.0})
        with log.stage(STAGE) as recorder:
            vertices, faces = zoo.icosphere(1)
            vertices = vertices / PolyhedralMetric.from_mesh(vertices, faces).unit
            kept = log.checkpoints.resume()
            left, x = (
                (self.steps, vertices * 2.0**self.steps) if kept is None else (int(kept["left"]), kept["x"])
            )
            while left:
                left, x = left - 1, x / 2
                recorder.iterations += 1
                if self.keeps:
                    recorder.keep(left=left, x=x)
                recorder.show(level="42 vertices", done=1 - left / self.steps)
                if left == self.stop and kept is None:
                    if self.wait:
                        print("kept", flush=True)
                        time.sleep(600)
                    os.kill(os.getpid(), self.number)
        return Embedding(metric, x, method=self.name, tolerance=tolerance, stages=log.stages)
