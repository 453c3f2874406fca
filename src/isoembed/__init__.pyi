from . import progress as progress
from ._embed import Method as Method
from ._embed import embed as embed
from .aim.adaptive import Aim as Aim
from .aim.paper import Paper as Paper
from .alexandrov.method import Alexandrov as Alexandrov
from .alexandrov.polyhedron import ConvexPolyhedron as ConvexPolyhedron
from .errors import Interrupted as Interrupted
from .errors import InvalidMetric as InvalidMetric
from .errors import InvalidParameter as InvalidParameter
from .errors import MeshNote as MeshNote
from .errors import NoHorizon as NoHorizon
from .errors import NoMinimum as NoMinimum
from .errors import NotEmbedded as NotEmbedded
from .gluing.net import glue as glue
from .gluing.unfolding import unfold as unfold
from .mesh.triangulation import Triangulation as Triangulation
from .metric.glued import GluedMetric as GluedMetric
from .metric.polyhedral import PolyhedralMetric as PolyhedralMetric
from .progress.stages import Checkpoint as Checkpoint
from .space import Euclidean as Euclidean
from .space import Hyperbolic as Hyperbolic
from .space import Space as Space
from .space import Spherical as Spherical
from .surface.embedding import Embedding as Embedding
from .surface.fitted import FittedSurface as FittedSurface

__version__: str
