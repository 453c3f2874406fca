"""File input and output: metrics, surfaces, nets, reports and checkpoints.

A file that cannot be read raises an error of one sentence; writing is atomic.
"""

from isoembed.io.checkpoint import (
    CHECKPOINT_ENDINGS,
    checkpoint_writer,
    read_checkpoint,
    write_checkpoint,
)
from isoembed.io.files import FileError, write_atomically
from isoembed.io.format import Format
from isoembed.io.input_file import InputFile
from isoembed.io.metric import metric_writer, read_metric, write_metric
from isoembed.io.objects import to_pyvista, to_trimesh
from isoembed.io.registry import MESH_ENDINGS, METRIC_ENDINGS, SURFACE_ENDINGS, check_output
from isoembed.io.report import REPORT_ENDINGS, report_writer, write_report
from isoembed.io.surface import mesh_writer, read_surface, surface_writer, write_surface

__all__ = [
    "CHECKPOINT_ENDINGS",
    "MESH_ENDINGS",
    "METRIC_ENDINGS",
    "REPORT_ENDINGS",
    "SURFACE_ENDINGS",
    "FileError",
    "Format",
    "InputFile",
    "check_output",
    "checkpoint_writer",
    "mesh_writer",
    "metric_writer",
    "read_checkpoint",
    "read_metric",
    "read_surface",
    "report_writer",
    "surface_writer",
    "to_pyvista",
    "to_trimesh",
    "write_atomically",
    "write_checkpoint",
    "write_metric",
    "write_report",
    "write_surface",
]
