"""The camera as numbers, views by name, and bookmarks: cameras that the scene keeps under a name."""

from __future__ import annotations

from dataclasses import replace

from imgui_bundle import imgui  # isort: skip
import numpy as np

from ..geometry.camera import Camera
from ..geometry.views import DIRECTIONS
from .widgets import CLAMP, LOG, Panel, chooser, tip

ENTER = imgui.InputTextFlags_.enter_returns_true.value
OWN = "as it is"  # where no view of a name is chosen


class CameraPanel(Panel):
    """Edits the camera of the scene that is shown. Moving it is no step of undo; bookmarks are."""

    def draw(self) -> None:
        """The controls."""
        camera, shown = self.actions.camera, self.session.shown
        if (new := chooser("view", shown.camera.view or OWN, [OWN, *DIRECTIONS])) and new != OWN:
            self.attempt(self.actions.choose_view, new)
        for name in ("eye", "target"):
            changed, numbers = imgui.input_float3(name, [float(v) for v in getattr(camera, name)], "%.4g", ENTER)
            tip("x right, y up, z to the front, metres; Enter takes them")
            if changed:
                self._change(camera, **{name: tuple(numbers)})
        self._angle(camera)
        changed, aperture = imgui.slider_float("aperture", camera.aperture, 0.0, 0.5, "%.3f m", CLAMP | LOG)
        tip(
            "diameter of the lens; it blurs by the samples per pixel, of which the refined picture has those of the scene"
        )
        if changed:
            self._change(camera, aperture=aperture)
        if camera.aperture > 0.0:
            changed, focus = imgui.slider_float("focus", camera.focus_distance, 0.01, 20.0, "%.3g m", CLAMP | LOG)
            tip("distance along the view of what is sharp")
            if changed:
                self._change(camera, focus=focus)
            if camera.focus is not None and imgui.small_button("focus at the target"):
                self._change(camera, focus=None)
        self._bookmarks()

    def _change(self, camera: Camera, **changes) -> None:
        self.attempt(lambda: self.actions.look(replace(camera, **changes)))

    def _angle(self, camera: Camera) -> None:
        """The angle of view, or the height of parallel rays."""
        changed, parallel = imgui.checkbox("parallel rays", camera.ortho is not None)
        half = np.linalg.norm(np.subtract(camera.target, camera.eye)) * np.tan(np.radians(camera.fov_deg) / 2)
        if changed:
            self._change(camera, ortho=2.0 * float(half) if parallel else None)
        elif camera.ortho is not None:
            changed, height = imgui.input_float("height", camera.ortho, 0.0, 0.0, "%.4g m", ENTER)
            if changed:
                self._change(camera, ortho=height)
        else:
            changed, angle = imgui.slider_float("angle of view", camera.fov_deg, 1.0, 120.0, "%.1f\u00b0", CLAMP)
            if changed:
                self._change(camera, fov_deg=angle)

    def _bookmarks(self) -> None:
        """Those of the scene, each a button; the first nine have keys."""
        actions = self.actions
        for number, name in enumerate(one.name for one in self.session.shown.bookmarks):
            if imgui.small_button(f"x##bookmark {number}"):
                self.attempt(actions.drop_bookmark, name)
            imgui.same_line()
            if imgui.button(f"{name}##bookmark {number} go"):
                self.attempt(actions.go_to_bookmark, name)
        if imgui.button("Bookmark this view"):
            self.attempt(actions.keep_bookmark)
        tip(
            "keeps the camera in the scene and its file; Ctrl+1 to Ctrl+9 keep, 1 to 9 go there, --view NAME renders it"
        )
