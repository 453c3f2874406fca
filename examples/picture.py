"""Embed a metric and draw the surface: ``python examples/picture.py metric.npz surface.png``."""

import sys
from pathlib import Path

import isoembed
from isoembed.io import read_metric
from isoembed.plot import write_picture

metric_file, picture_file = sys.argv[1:]
surface = isoembed.embed(read_metric(metric_file))
write_picture(Path(picture_file), surface)
