"""The weave's panel: the draft as a grid to click and drag, the yarns' measures as sliders, and the cloth near by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui  # isort: skip
import numpy as np

from ..color import srgb_encode
from ..fabric import Fabric
from ..weave.draft import Draft
from ..weave.loom import Loom
from ..weave.model import Irregularity, Weave
from ..weave.named import WEAVES
from . import draft_grid
from .actions import Actions
from .controls import controls
from .dialogs import available
from .draft_grid import Cell, Grid, said
from .files import DRAFTS, Files
from .thread_colors import Pen, color_of, painted
from .widgets import CLAMP, GREY, Panel, buttons, chooser, tip

SETT = controls(Weave, ("ends_per_cm", "picks_per_cm"))
YARNS = controls(
    Weave,
    (
        "width",
        "flat",
        "crimp",
        "bow",
        "twist_deg",
        "pinch",
        "occlusion",
        "roll",
        "relief",
        "fuzz",
        "fuzz_length",
        "colors",
        "far",
    ),
)
STEEPEST = controls(Weave, ("tilt_deg",))[0]
IRREGULAR = controls(Irregularity)
PAPER, INK, UNUSED = (0.90, 0.89, 0.86), (0.12, 0.22, 0.45), (0.21, 0.21, 0.22)
SMALLEST, LARGEST = 7, 17  # points a cell
EDITED = ", edited"
HINT = "click a crossing; drag in threading, tie-up, treadling"
MOST = 64  # threads that the buttons add up to; drafts may have more
LOW_PLAIN = {"draft": "plain", "ends_per_cm": 20.0, "picks_per_cm": 20.0, "far": "yarns"}


class WeavePanel(Panel):
    """The weave of the fabric that is shown."""

    def __init__(self, actions: Actions, files: Files):
        super().__init__(actions)
        self.files = files
        self._loom: Loom | None = None  # may be several repeats of the weave's draft
        # Since the last edit: the loom and the draft that the buttons + and - repeat, and the loom that they made.
        self._repeated: tuple[Loom, Draft, Loom] | None = None
        self._pen, self._said = Pen(), HINT
        self._held: tuple[Cell, bool, Grid] | None = None  # where the pointer draws, what, and on which grid it began

    def draw(self) -> None:
        """All controls of the weave."""
        fabric = self.session.fabric
        if fabric.weave is None:
            self._none(fabric)
            return
        imgui.push_id("weave page")
        self._near()
        self._draft(fabric.weave)
        self._threads(fabric)
        self._measures(fabric.weave)
        self._file()
        imgui.pop_id()

    def edit(self, gesture: str | None, **changes) -> None:
        """Change fields of the weave."""
        self.session.edit_weave(gesture, **changes)

    # -- parts -------------------------------------------------------------------------------------------------------

    def _none(self, fabric: Fabric) -> None:
        imgui.push_text_wrap_pos(0.0)
        imgui.text(
            f"{fabric.name} has no [weave], which says how its threads lie. Choose a fabric that has one, drop a draft "
            "(.wif) on the window, or give this one a weave; from afar it then stays as it is."
        )
        imgui.pop_text_wrap_pos()
        buttons(("Give it a plain weave", lambda: self.attempt(self.session.give_weave, LOW_PLAIN), True))

    def _near(self) -> None:
        """Two centimetres of the cloth, and the way to the picture's own threads."""
        actions, session = self.actions, self.session
        if session.in_curtain:
            imgui.text_colored(GREY, "the curtain is traced without threads")
            return
        texture, aspect = actions.near_picture()
        width = imgui.get_content_region_avail().x
        if texture is None:
            imgui.text_colored(GREY, "the first view near by compiles its programs for some seconds")
            imgui.dummy((width, width / aspect - imgui.get_text_line_height_with_spacing()))
        else:
            imgui.image(imgui.ImTextureRef(texture.glo), (width, width / aspect), (0.0, 1.0), (1.0, 0.0))
            tip("2 cm of the cloth, seen 25 degrees from above it, in the light of the scene; ends run upright")
        changed, on = imgui.checkbox("threads in the picture", session.scene.threads)
        tip("threads where one comes near; off, cloth is shown as it is from afar")
        if changed:
            self.attempt(session.edit_scene, threads=on)
        imgui.same_line()
        buttons(("Go near", self._go_near, True))
        tip("four centimetres of the cloth in the picture, with threads; Home goes back")

    def _go_near(self) -> None:
        if not self.session.scene.threads:
            self.attempt(self.session.edit_scene, threads=True)
        self.actions.go_near()

    def _draft(self, weave: Weave) -> None:
        name = weave.draft if isinstance(weave.draft, str) else weave.draft.title or "own draft"
        if new := chooser("draft", name, list(WEAVES)):
            self.attempt(self.session.choose_weave, new)
            return
        self._grid(weave)

    def _threads(self, fabric: Fabric) -> None:
        """How many threads the grid has, and the sett."""
        assert fabric.weave is not None
        loom = self._loom_of(fabric.weave)
        picks, ends = loom.drawdown.shape
        size = {"ends": (picks, ends + 1), "fewer ends": (picks, ends - 1)}
        size |= {"picks": (picks + 1, ends), "fewer picks": (picks - 1, ends)}
        for word, count in (("ends", ends), ("picks", picks)):
            imgui.text(f"{count} {word}")
            for sign, key in (("+", word), ("-", f"fewer {word}")):
                imgui.same_line()
                imgui.begin_disabled(not all(1 <= n <= MOST for n in size[key]))
                pressed = imgui.small_button(f"{sign}##{word}")
                imgui.end_disabled()
                tip("threads on the grid; new ones go on with the repeat that was there")
                if pressed:
                    self._resize(loom, fabric.weave.drafted, size[key])
            if word == "ends":
                imgui.same_line(0.0, 24 * self.actions.layout.scale)
        for item in SETT:
            value = getattr(fabric.weave, item.name)
            label = item.label.replace("per", "/")
            changed, new = imgui.slider_float(label, value, 2.0, 200.0, "%.4g", CLAMP | _LOG)
            tip(f"{item.help}\n{item.low:g} to {item.high:g}; Ctrl+click to type")
            if changed:
                self.attempt(self.edit, f"weave {item.name}", **{item.name: float(f"{new:.4g}")})

    def _measures(self, weave: Weave) -> None:
        origin = self.session.origin.weave or weave
        for item in YARNS:
            self.field(item, self.session.fabric.weave, self.edit, f"weave {item.name}", origin)
        now = self.session.fabric.weave
        assert now is not None
        own = now.tilt_deg is not None
        changed, by_hand = imgui.checkbox("largest tilt by hand", own)
        tip("else it follows from crimp and sett")
        if changed:
            found = tuple(round(float(np.degrees(t)), 1) for t in now.shape.largest_tilts)
            self.attempt(self.edit, None, tilt_deg=found if by_hand else None)
        elif own:
            self.field(STEEPEST, now, self.edit, "weave tilt", origin if origin.tilt_deg is not None else None)
        imgui.text_colored(GREY, "irregularity")
        for item in IRREGULAR:
            loose = self.session.fabric.weave.irregularity
            self.field(item, loose, self._loosen, f"weave {item.name}", origin.irregularity)

    def _loosen(self, gesture: str | None, **changes) -> None:
        loose = self.session.fabric.weave.irregularity
        self.edit(gesture, irregularity=loose.changed(**changes))

    def _file(self) -> None:
        """Drafts in and out."""
        names = self.files.names
        _, names["draft"] = imgui.input_text("##draft path", names["draft"])
        rows: tuple[tuple[str, Callable[[str], None], str], ...] = (
            ("Save draft", self.files.save_draft, "writes a .wif at this sett, in these colours"),
            ("Load draft", self.files.load_draft, "takes another draft (.wif .dtx .wpo .twa); the yarns stay"),
        )
        for label, act, what in rows:
            imgui.same_line()
            if imgui.small_button(label):
                act(names["draft"])
            tip(what)
        if available() and imgui.small_button("choose a draft ..."):
            self.files.dialogs.open("Draft", DRAFTS, self.files.load_draft)

    # -- the grid ----------------------------------------------------------------------------------------------------

    def _loom_of(self, weave: Weave) -> Loom:
        """The loom on the grid: the one that was drawn, as long as it weaves the weave's draft; else the draft's own."""
        draft = weave.drafted
        drawn = self._loom
        if drawn is None or not _weaves(drawn, draft.drawdown):
            loom = Loom.of(draft.drawdown)
            # After an undo the grid keeps its size where the draft still fits it.
            if drawn is not None and all(
                a % b == 0 for a, b in zip(drawn.drawdown.shape, draft.drawdown.shape, strict=True)
            ):
                loom = loom.resized(*drawn.drawdown.shape)
            self._loom = loom
        assert self._loom is not None
        return self._loom

    def _resize(self, loom: Loom, draft: Draft, size: tuple[int, int]) -> None:
        """So many picks and ends: the repeat of before the first press goes on, and comes back."""
        if self._repeated is None or self._repeated[2] is not loom:
            self._repeated = loom, draft, loom
        first, like, _ = self._repeated
        new = first.resized(*size)
        self._repeated = first, like, new
        self._take(new, None, like)

    def _take(self, loom: Loom, gesture: str | None, like: Draft | None = None) -> None:
        """Show another loom, and weave what it weaves with threads as those of `like`, or as they are."""
        weave = self.session.fabric.weave
        assert weave is not None
        before, self._loom = self._loom, loom
        source = like or weave.drafted
        draft = loom.draft(source).reduced()
        if draft != source:
            draft = replace(draft, title=f"{draft.title.removesuffix(EDITED)}{EDITED}")
        if draft == weave.drafted:
            return

        def edit() -> None:
            try:
                self.edit(gesture, draft=draft)
            except BaseException:
                self._loom = before
                raise

        self.attempt(edit)

    def _grid(self, weave: Weave) -> None:
        loom, scale = self._loom_of(weave), self.actions.layout.scale
        grid = self._held[2] if self._held is not None else Grid.of(loom)
        columns, rows = grid.size
        room = imgui.get_content_region_avail().x
        cell = float(np.clip(room // columns, SMALLEST * scale, LARGEST * scale))
        height = min(rows * cell, 330 * scale)
        flags = imgui.WindowFlags_
        scroll = columns * cell > room or rows * cell > height
        extra = 16 * scale if scroll else 0.0
        window = flags.horizontal_scrollbar.value if scroll else flags.no_scrollbar.value
        imgui.push_style_var(imgui.StyleVar_.window_padding, (0.0, 0.0))
        if imgui.begin_child("##grid", (room, height + extra), 0, window):
            low = imgui.get_cursor_screen_pos()
            imgui.invisible_button("##draft grid", (columns * cell, rows * cell))
            self._draw_on(loom, grid, (low.x, low.y), cell)
            loom = self._loom_of(self.session.fabric.weave or weave)
            _paint(loom, grid, weave_colors(self.session.fabric), (low.x, low.y), cell, (room, height))
        imgui.end_child()
        imgui.pop_style_var()
        imgui.text_colored(GREY, self._said)
        self._pen.draw(self.session.fabric, scale)

    def _draw_on(self, loom: Loom, grid: Grid, low: tuple[float, float], cell: float) -> None:
        """Mark the cells that the pointer passes; the first says whether it marks or clears. On the strips the pen paints."""
        held = self._held
        self._under(loom, grid, low, cell)
        if not imgui.is_item_active():
            self._held = None
            # A last motion may come in the same step as the release.
            if held is None or not imgui.is_item_deactivated():
                return
        mouse = imgui.get_mouse_pos()
        at = grid.cell((mouse.x - low[0]) / cell, (mouse.y - low[1]) / cell)
        if at is None or (held is not None and at.part != held[0].part):
            return
        if imgui.is_item_activated():
            up, cells = not draft_grid.is_set(loom, at), [at]
        elif held is None or at == held[0]:
            return
        else:
            up, cells = held[1], draft_grid.between(held[0], at)
        if imgui.is_item_active():
            self._held = at, up, grid
        if at.part in ("warp", "weft"):
            self._paint_threads(loom, cells)
            return
        for one in cells:
            loom = draft_grid.marked(loom, one, up)
        self._take(loom, "weave grid")

    def _under(self, loom: Loom, grid: Grid, low: tuple[float, float], cell: float) -> None:
        """Say what the cell under the pointer is; the right button takes up a thread's colour."""
        self._said = HINT
        if not imgui.is_item_hovered() and self._held is None:
            return
        mouse = imgui.get_mouse_pos()
        at = grid.cell((mouse.x - low[0]) / cell, (mouse.y - low[1]) / cell)
        if at is None or not _exists(loom, at):
            return
        self._said = said(loom, at)
        if at.part in ("warp", "weft") and imgui.is_mouse_clicked(1):
            self._pen.color = color_of(self.session.fabric, at)

    def _paint_threads(self, loom: Loom, cells: list[Cell]) -> None:
        changes, loom = painted(self.session.fabric, loom, cells, self._pen.color)
        draft = changes["draft"]
        changes["draft"] = replace(draft, title=f"{draft.title.removesuffix(EDITED)}{EDITED}")
        before, self._loom = self._loom, loom

        def edit() -> None:
            try:
                self.edit("weave colours", **changes)
            except BaseException:
                self._loom = before
                raise

        self.attempt(edit)


_LOG = imgui.SliderFlags_.logarithmic.value


def weave_colors(fabric: Fabric) -> tuple[np.ndarray, np.ndarray]:
    """Display colours of the ends and of the picks in order, [n, 3], cyclic; brightened as one sees single threads."""
    weave = fabric.weave
    assert weave is not None
    own = weave.thread_colors or tuple(np.array([yarn.albedo]) for yarn in fabric.yarn)
    warp, weft = (srgb_encode(np.clip(2.0 * np.asarray(c, float), 0.0, 1.0)) for c in own)
    return warp, weft


def _weaves(loom: Loom, drawdown: np.ndarray) -> bool:
    """Whether a loom's drawdown is whole repeats of another one."""
    picks, ends = drawdown.shape
    own = loom.drawdown
    if own.shape[0] % picks or own.shape[1] % ends:
        return False
    return bool((own == np.tile(drawdown, (own.shape[0] // picks, own.shape[1] // ends))).all())


def _code(color) -> int:
    return imgui.color_convert_float4_to_u32((float(color[0]), float(color[1]), float(color[2]), 1.0))


def _paint(loom: Loom, grid: Grid, colors, low: tuple[float, float], cell: float, room: tuple[float, float]) -> None:
    """Draw the cells that are in sight."""
    draw = imgui.get_window_draw_list()
    pen = max(round(cell / 12), 1)
    left, top = imgui.get_scroll_x(), imgui.get_scroll_y()
    columns = range(int(left // cell), min(int((left + room[0]) // cell) + 1, grid.size[0]))
    rows = range(int(top // cell), min(int((top + room[1]) // cell) + 1, grid.size[1]))
    paper, unused = _code(PAPER), _code(UNUSED)
    ink = _code(INK)
    warp, weft = ([_code(c) for c in side] for side in colors)
    plain = (
        len(warp) == len(weft) == 1 or len({*warp, *weft}) == 1
    )  # yarns of one colour each: ink on paper is easier to read
    for x in columns:
        for y in rows:
            a = low[0] + x * cell, low[1] + y * cell
            b = a[0] + cell - pen, a[1] + cell - pen
            at = grid.cell(x + 0.5, y + 0.5)
            if at is None:
                continue
            on = draft_grid.is_set(loom, at)
            if at.part in ("warp", "weft"):
                code = warp[at.column % len(warp)] if at.part == "warp" else weft[at.row % len(weft)]
            elif at.part != "drawdown" or plain:
                code = ink if on else paper if _exists(loom, at) else unused
            else:
                code = warp[at.column % len(warp)] if on else weft[at.row % len(weft)]
            draw.add_rect_filled(a, b, code)


def _exists(loom: Loom, cell: Cell) -> bool:
    """Whether the loom has the shaft and the treadle of a cell, the next new ones included."""
    shafts, treadles = loom.shafts, loom.treadles
    part, row, column = cell
    if part == "threading":
        return row <= shafts
    if part == "treadling":
        return column <= treadles
    return part in ("drawdown", "warp", "weft") or (row < shafts and column < treadles)
