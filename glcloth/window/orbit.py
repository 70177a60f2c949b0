"""Moving the eye: orbit, pan, zoom and frame as pure functions of a camera."""

from __future__ import annotations

import numpy as np
from pyrr import vector

from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..scene import View

POLE_DEG = 1.0  # the eye stays this far from straight above and below, where "up" ends


def view_of(camera: Camera) -> View:
    """The camera as a scene keeps it."""
    return View(eye=camera.eye, target=camera.target, up=camera.up, fov_deg=camera.fov_deg)


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
    return Camera(tuple(eye), camera.target, camera.up, camera.fov_deg)


def pan(camera: Camera, right: float, up: float) -> Camera:
    """Move eye and target across the view, in units of the picture's height at the target."""
    x, y, _ = camera.axes
    distance = np.linalg.norm(np.subtract(camera.eye, camera.target))
    step = 2.0 * distance * np.tan(np.radians(camera.fov_deg) / 2) * (right * x + up * y)
    return Camera(tuple(camera.eye + step), tuple(camera.target + step), camera.up, camera.fov_deg)


def zoom(camera: Camera, factor: float, radius: float) -> Camera:
    """Scale the distance to the target; it stays between a thousandth and a hundred times the mesh's radius."""
    arm = np.subtract(camera.eye, camera.target)
    distance = np.linalg.norm(arm)
    wanted = np.clip(distance * factor, 1e-3 * radius, 1e2 * radius)
    eye = np.asarray(camera.target) + arm * (wanted / distance)
    return Camera(tuple(eye), camera.target, camera.up, camera.fov_deg)


def frame(camera: Camera, mesh: Mesh, aspect: float) -> Camera:
    """The same direction of view, with the whole mesh in the picture."""
    arm = np.subtract(camera.eye, camera.target)
    framed = Camera.framing(mesh.center, mesh.radius, arm, camera.fov_deg, aspect)
    return Camera(framed.eye, framed.target, camera.up, camera.fov_deg)
