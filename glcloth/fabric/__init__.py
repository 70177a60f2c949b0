"""Fabrics: what a weave is made of, as frozen values, and their files."""

from .fabric import MAX_TANGENTS, Fabric, Tangent
from .files import FABRICS, builtin_fabrics, draft_fabric, load_fabric, save_fabric
from .transmission import Transmission
from .yarn import Yarn
