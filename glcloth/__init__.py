"""Woven cloth as it really looks, from Python, on OpenGL.

The public names are imported when they are first used, so that `import glcloth` and the command line start at once.
"""

from importlib import import_module

__version__ = "0.1.0"

_PUBLIC = {
    "Camera": "geometry.camera",
    "Draft": "weave.draft",
    "Environment": "light.environment",
    "Fabric": "fabric",
    "InputError": "errors",
    "Lights": "light.lights",
    "Mesh": "geometry.mesh",
    "NoOpenGLError": "errors",
    "Renderer": "picture.renderer",
    "Scene": "scene",
    "SphericalGaussians": "light.lights",
    "Suns": "light.lights",
    "View": "scene",
    "Weave": "weave.model",
    "Yarn": "fabric",
    "compare": "metrics",
    "fit_lights": "light.fit",
    "load_draft": "weave.wif",
    "load_environment": "light.environment",
    "load_fabric": "fabric",
    "load_mesh": "geometry.mesh_files",
    "load_scene": "scene",
    "read_image": "image",
    "save_draft": "weave.wif",
    "save_fabric": "fabric",
    "save_mesh": "geometry.mesh_files",
    "save_scene": "scene",
    "show": "window.show",
    "tables_for": "methods.paper.tables",
    "tables_report": "methods.paper.tables",
    "write_image": "image",
}
__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str):
    if name not in _PUBLIC:
        raise AttributeError(f"module 'glcloth' has no attribute {name!r}")
    value = getattr(import_module(f".{_PUBLIC[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
