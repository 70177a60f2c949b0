"""A scene: everything that determines a picture, as one frozen value, and its files."""

from .curtain_parameters import CurtainParameters
from .files import builtin_scenes, header, load_scene, save_scene
from .maps import MAPS, ClothMap, FabricMaskMap, OpacityMap, PrintMap
from .scene import CURTAIN, MethodName, Quality, Scene, ShadowMode, kind_of
from .view import View
