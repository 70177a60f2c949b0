"""Where picture and panels are in the window."""

from __future__ import annotations

from .host import Host
from .screen import Rectangle
from .state import Session

PANEL = 400  # points: width of the panels


class Layout:
    """Divides the window of a host; `follow`: the picture is as large as the place that the panels leave."""

    def __init__(self, host: Host, session: Session):
        self.host, self.session = host, session
        self.show_panels = self.follow = True

    @property
    def scale(self) -> float:
        """The window's own units to a point."""
        return self.host.scale

    def area(self) -> tuple[int, int]:
        """Pixels that the panels leave for the picture."""
        width, height = self.host.framebuffer_size
        return max(width - self.panel_width(), 16), max(height, 16)

    def panel_width(self) -> int:
        """Width of the panels in pixels of the framebuffer, which they never leave."""
        if not self.show_panels:
            return 0
        return min(round(PANEL * self.scale * self.host.pixels_per_point), self.host.framebuffer_size[0])

    def toggle_panels(self) -> None:
        """Show the panels, or hide them."""
        self.show_panels = not self.show_panels

    def update(self) -> None:
        """Give the picture the size of its place, where it follows that."""
        if self.follow and (area := self.area()) != self.session.shown.size:
            self.session.move(size=area)

    def rectangle(self) -> Rectangle:
        """Where the picture is in the framebuffer. Shrunk to fit, never enlarged."""
        area, size = self.area(), self.session.shown.size
        factor = min(1.0, area[0] / size[0], area[1] / size[1])
        width, height = max(1, round(size[0] * factor)), max(1, round(size[1] * factor))
        return (area[0] - width) // 2, (area[1] - height) // 2, width, height
