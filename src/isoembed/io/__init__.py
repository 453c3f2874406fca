"""Files: metrics in, surfaces and reports out.  Every file is read with one clear sentence or not at all.

`read_metric` takes arrays or meshes by their ending; what is written is written whole or not at all.
"""

from isoembed.io.files import FileError, check_output, write_whole
from isoembed.io.metric import metric_writer, read_metric, write_metric
from isoembed.io.registry import MESH_ENDINGS, METRIC_ENDINGS, SURFACE_ENDINGS
from isoembed.io.report import REPORT_ENDINGS, report_writer, write_report
from isoembed.io.surface import mesh_writer, surface_writer, write_surface

__all__ = [
    "MESH_ENDINGS",
    "METRIC_ENDINGS",
    "REPORT_ENDINGS",
    "SURFACE_ENDINGS",
    "FileError",
    "check_output",
    "mesh_writer",
    "metric_writer",
    "read_metric",
    "report_writer",
    "surface_writer",
    "write_metric",
    "write_report",
    "write_surface",
    "write_whole",
]
