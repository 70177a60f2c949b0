"""Moving the eye: orbit, pan, zoom and frame as pure functions of a camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pyrr import vector

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..scene import View

POLE_DEG = 1.0  # the eye stays this far from straight above and below, where "up" ends


def view_of(camera: Camera) -> View:
    """The camera as a scene keeps it. What rounding leaves of 0 is 0: scenes take no such small lengths."""
    eye, target = (tuple(0.0 if abs(x) < 1e-12 else x for x in place) for place in (camera.eye, camera.target))
    return View.of(replace(camera, eye=eye, target=target))


def orbit(camera: Camera, right_deg: float, up_deg: float) -> Camera:
    """Turn the eye about the target: `right_deg` about the up axis, `up_deg` toward it."""
    up = vector.normalise(np.asarray(camera.up, float))
    arm = np.subtract(camera.eye, camera.target)
    distance = np.linalg.norm(arm)
    elevation = np.degrees(np.arcsin(np.clip(arm @ up / distance, -1.0, 1.0)))
    flat = vector.normalise(arm - (arm @ up) * up)
    a = np.radians(right_deg)
    flat = np.cos(a) * flat + np.sin(a) * np.cross(up, flat)
    e = np.radians(np.clip(elevation + up_deg, POLE_DEG - 90.0, 90.0 - POLE_DEG))
    eye = np.asarray(camera.target) + distance * (np.cos(e) * flat + np.sin(e) * up)
    return replace(camera, eye=tuple(eye))


def pan(camera: Camera, right: float, up: float) -> Camera:
    """Move eye and target across the view, in units of the picture's height at the target."""
    x, y, _ = camera.axes
    distance = np.linalg.norm(np.subtract(camera.eye, camera.target))
    height = camera.ortho or 2.0 * distance * np.tan(np.radians(camera.fov_deg) / 2)
    step = height * (right * x + up * y)
    return replace(camera, eye=tuple(camera.eye + step), target=tuple(camera.target + step))


def zoom(camera: Camera, factor: float, radius: float) -> Camera:
    """Scale the distance to the target, or of parallel rays the picture's height; it stays between a thousandth and a hundred
    times the mesh's radius."""
    if camera.ortho is not None:
        return replace(camera, ortho=float(np.clip(camera.ortho * factor, 1e-3 * radius, 1e2 * radius)))
    arm = np.subtract(camera.eye, camera.target)
    distance = np.linalg.norm(arm)
    wanted = np.clip(distance * factor, 1e-3 * radius, 1e2 * radius)
    eye = np.asarray(camera.target) + arm * (wanted / distance)
    return replace(camera, eye=tuple(eye))


def frame(camera: Camera, mesh: Mesh, aspect: float) -> Camera:
    """The same direction of view, with the whole mesh in the picture."""
    arm = np.subtract(camera.eye, camera.target)
    framed = Camera.framing(mesh.center, mesh.radius, arm, camera.fov_deg, aspect)
    ortho = None if camera.ortho is None else 2.0 * mesh.radius / min(aspect, 1.0)
    return replace(camera, eye=framed.eye, target=framed.target, ortho=ortho)
