"""Programs on the GPU: one cache for each context; what a program reads and writes is bound by its name in GLSL.

A GLSL file declares its textures, images and storage blocks without binding numbers; `number` gives them out. Python
names them: `programs.compute("passes/accel/rays.comp").run(count, rays=buffer, Hits=hits, ray_count=count)`.
Samplers, images and uniforms go by their own name, storage blocks by the name of the block.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import moderngl
import numpy as np
from OpenGL import GL

from ..errors import ShaderError
from .buffers import Buffer, TextureBuffer
from .context_local import of_context
from .shader import Where, explain, flatten
from .tally import Tally

Inputs = Mapping[str, Any]
ITEM = "inputs/gpu/item.glsl"  # by which a pass tells its invocations apart, however they are laid out

_COMMENT = re.compile(r"//[^\n]*")
_RESOURCE = re.compile(
    r"^[ \t]*(?:layout\((?P<layout>[^)]*)\)[ \t]*)?(?P<before>(?:(?:readonly|writeonly|coherent|restrict|volatile)\s+)*)"
    r"(?:uniform\s+(?P<after>(?:(?:readonly|writeonly|coherent|restrict)\s+)*)"
    r"(?P<kind>[iu]?(?:sampler|image)\w+)\s+(?P<name>\w+)\s*;|buffer\s+(?P<block>\w+))",
    re.M,
)
_UNIFORM = re.compile(r"\buniform\s+(float|u?int|bool|[iub]?vec[234]|mat[234])\s+([^;]+);")
_BINDING = re.compile(r"\s*,?\s*binding\s*=\s*\d+")


class Slot(NamedTuple):
    """Where one texture, image or storage block of a program is bound."""

    kind: str  # texture, image, block
    number: int
    reads: bool = True
    writes: bool = True


def number(text: str, slots: dict[str, Slot]) -> str:
    """Return a flat GLSL text in which every texture, image and storage block has a binding number.

    `slots` {name: Slot} is extended by what the text declares; a name that it holds already keeps its number, so the
    stages of one program and the branches of an #if agree.
    """

    def declare(match: re.Match) -> str:
        name = match["block"] or match["name"]
        qualifiers = (match["before"] or "") + (match["after"] or "")
        kind = "block" if match["block"] else "image" if "image" in match["kind"] else "texture"
        if name not in slots:
            taken = sum(slot.kind == kind for slot in slots.values())
            reads, writes = "writeonly" not in qualifiers, "readonly" not in qualifiers
            slots[name] = Slot(kind, taken, reads, writes)
        layout = _BINDING.sub("", match["layout"] or "").strip(" ,")
        own = f"layout({layout}{', ' if layout else ''}binding = {slots[name].number}) {match['before'] or ''}"
        if match["block"]:
            return f"{own}buffer {name}"
        return f"{own}uniform {match['after'] or ''}{match['kind']} {name};"

    return _RESOURCE.sub(declare, text)


def uniforms(text: str) -> dict[str, str]:
    """Return {name: type} of the plain uniforms that a flat GLSL text declares."""
    found = {}
    for kind, names in _UNIFORM.findall(_COMMENT.sub("", text)):
        for name in names.split(","):
            found[re.split(r"[\s\[=]", name.strip())[0]] = kind
    return found


def _dtype(kind: str) -> str:
    if kind == "uint" or kind.startswith("uvec"):
        return "u4"
    return "f4" if kind == "float" or kind.startswith(("vec", "mat")) else "i4"


class Program:
    """One linked program, with names for all that it reads and writes."""

    def __init__(self, path: str, linked, slots: dict[str, Slot], declared: dict[str, str]):
        self.path, self.linked, self.slots = path, linked, slots
        self._declared = slots.keys() | declared.keys()
        self._binders: dict[str, Callable[[Any], None]] = {name: _binder(slot) for name, slot in slots.items()}
        for name, kind in declared.items():
            # A driver drops the uniforms that nothing reads.
            if (uniform := linked.get(name, None)) is not None:
                self._binders[name] = _Uniform(uniform, kind)

    def bind(self, *inputs: Inputs, **own: Any) -> None:
        """Bind textures, images and storage blocks, and set uniforms, by their names in GLSL.

        Parameters
        ----------
        inputs : mappings of names; those that the program does not declare are left out
        own : names that the program must declare

        A texture takes a moderngl.Texture or a TextureBuffer; a block a Buffer; a uniform a number, a tuple, or an
        array (matrices in row order). Raises ShaderError for a name in `own` that nothing declares.
        """
        if not own.keys() <= self._declared:
            raise ShaderError(f"glsl/{self.path} declares no `{next(n for n in own if n not in self._declared)}`")
        given: dict[str, Any] = {}
        for mapping in inputs:
            given.update(mapping)
        given.update(own)
        for name, bind in self._binders.items():
            if name in given:
                bind(given[name])

    def declares(self, name: str) -> bool:
        """Whether the text of the program has a texture, image, block or uniform of this name."""
        return name in self._declared

    def release(self) -> None:
        """Free the program."""
        self.linked.release()


def _binder(slot: Slot) -> Callable[[Any], None]:
    """The function that binds a texture, an image or a buffer to a slot."""
    number = slot.number
    if slot.kind == "block":
        return lambda value: (value.buffer if isinstance(value, Buffer) else value).bind_to_storage_buffer(number)
    if slot.kind == "image":
        return lambda value: value.bind_to_image(number, read=slot.reads, write=slot.writes)
    return lambda value: value.bind(number) if isinstance(value, TextureBuffer) else value.use(number)


class _Uniform:
    """Sets a uniform where it differs from what it was set to last: a third of the host's time of a dispatch."""

    def __init__(self, uniform, kind: str):
        self._uniform, self._dtype, self._turned = uniform, _dtype(kind), kind.startswith("mat")
        self._pack = struct.Struct(uniform.fmt).pack
        self._last = b""

    def __call__(self, value: Any) -> None:
        uniform = self._uniform
        if isinstance(value, np.ndarray) or uniform.array_length > 1:
            value = np.asarray(value, self._dtype)
            data = (value.swapaxes(-1, -2) if self._turned else value).tobytes()
            # A driver may keep fewer elements of an array than its text declares.
            data = data[: 4 * uniform.dimension * uniform.array_length]
        else:
            data = self._pack(*value) if uniform.dimension > 1 else self._pack(value)
        if data != self._last:
            uniform.write(data)
            self._last = data


class Compute(Program):
    """A compute program."""

    def __init__(
        self, owner: Programs, path: str, linked, slots: dict[str, Slot], declared: dict[str, str], rows: bool
    ):
        super().__init__(path, linked, slots, declared)
        self.ctx, self._owner, self._tally = owner.ctx, owner, of_context(Tally, owner.ctx)
        self._rows = rows  # whether the pass can be laid in rows of work groups
        size = (GL.GLint * 3)()
        GL.glGetProgramiv(linked.glo, GL.GL_COMPUTE_WORK_GROUP_SIZE, size)
        self.group_size = tuple(size)

    def run(self, items: int | tuple[int, ...], *inputs: Inputs, **own: Any) -> None:
        """Bind as `bind` does, run one invocation for each item, and make what was written visible to all that follows.

        `items`: how many along x, or along x, y and z; rounded up to whole work groups. None at all: nothing happens.
        """
        items = (items,) if isinstance(items, int | np.integer) else items
        groups = tuple(-(-int(n) // size) for n, size in zip(items, self.group_size, strict=False))
        self._dispatch(groups, int(math.prod(items)), inputs, own)

    def run_groups(self, groups: int | tuple[int, ...], *inputs: Inputs, **own: Any) -> None:
        """As `run`, for so many work groups."""
        groups = (groups,) if isinstance(groups, int | np.integer) else groups
        self._dispatch(groups, int(math.prod(groups)) * math.prod(self.group_size), inputs, own)

    def _dispatch(self, groups: tuple[int, ...], items: int, inputs: tuple[Inputs, ...], own: dict[str, Any]) -> None:
        """Bind and run.

        More groups along one line than the device takes are laid in rows; raises ShaderError if the pass does not know of
        rows.
        """
        if min(groups) <= 0:
            return
        most = self._owner.most_groups
        if groups[0] > most and len(groups) == 1:
            if not self._rows:
                raise ShaderError(f"glsl/{self.path}: {groups[0]} work groups, more than {most}, need {ITEM}")
            rows = -(-groups[0] // most)
            groups = -(-groups[0] // rows), rows
        self.bind(*inputs, **own)
        self._tally.dispatch(self.path, items)
        self.linked.run(*map(int, groups))
        self.ctx.memory_barrier()

    def run_indirect(self, arguments: Buffer, *inputs: Inputs, skip: int = 0, **own: Any) -> None:
        """As `run_groups`, for as many work groups as three numbers of a buffer on the GPU say, behind `skip` bytes."""
        self.bind(*inputs, **own)
        self._tally.dispatch(self.path, None)
        self.linked.run_indirect(arguments.buffer, skip)
        self.ctx.memory_barrier()


class Draw(Program):
    """A program of a vertex and a fragment pass."""

    def __init__(self, ctx: moderngl.Context, path: str, linked, slots: dict[str, Slot], declared: dict[str, str]):
        super().__init__(path, linked, slots, declared)
        self._ctx = ctx
        self._screen: moderngl.VertexArray | None = None

    @property
    def screen(self) -> moderngl.VertexArray:
        """The vertex array of a draw that fetches no vertices."""
        if self._screen is None:
            self._screen = self._ctx.vertex_array(self.linked, [])
        return self._screen

    def release(self) -> None:
        """Free the program and its vertex array."""
        if self._screen is not None:
            self._screen.release()
        super().release()


class Programs:
    """The programs of a context, each compiled when it is first asked for."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.most_groups: int = ctx.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]  # along x
        self._programs: dict[tuple, Program] = {}

    def __len__(self) -> int:
        """How many are compiled."""
        return len(self._programs)

    def compute(self, path: str, defines: Inputs | None = None, virtual: Mapping[str, str] | None = None) -> Compute:
        """The program of one compute pass; parameters as for `shader.flatten`. Raises ShaderError."""
        key = _key(path, defines, virtual)
        if key not in self._programs:
            slots: dict[str, Slot] = {}
            text, where = flatten(path, defines, virtual)
            text = number(text, slots)
            linked = _compiled(lambda: self.ctx.compute_shader(text), lambda log: where)
            rows = any(file == ITEM for file, _ in where)
            self._programs[key] = Compute(self, path, linked, slots, uniforms(text), rows)
        program = self._programs[key]
        assert isinstance(program, Compute)
        return program

    def draw(
        self,
        vertex: str,
        fragment: str,
        defines: Inputs | None = None,
        virtual: Mapping[str, str] | None = None,
    ) -> Draw:
        """The program of a vertex and a fragment pass; parameters as for `shader.flatten`. Raises ShaderError."""
        key = _key(f"{vertex} {fragment}", defines, virtual)
        if key not in self._programs:
            slots: dict[str, Slot] = {}
            texts, wheres = [], []
            for path in (vertex, fragment):
                text, where = flatten(path, defines, virtual)
                texts.append(number(text, slots))
                wheres.append(where)
            linked = _compiled(
                lambda: self.ctx.program(vertex_shader=texts[0], fragment_shader=texts[1]),
                # moderngl heads a log with the stage it belongs to; a link error belongs to none.
                lambda log: wheres[0 if re.search(r"^vertex_shader", log, re.M) else 1],
            )
            self._programs[key] = Draw(self.ctx, fragment, linked, slots, uniforms("".join(texts)))
        program = self._programs[key]
        assert isinstance(program, Draw)
        return program

    def screen(self, fragment: str, defines: Inputs | None = None, virtual: Mapping[str, str] | None = None) -> Draw:
        """The program that runs a fragment pass over the screen, for `screen.draw_screen`."""
        return self.draw("passes/picture/screen.vert", fragment, defines, virtual)


def programs(ctx: moderngl.Context) -> Programs:
    """The programs of a context."""
    return of_context(Programs, ctx)


@contextmanager
def recompiled(ctx: moderngl.Context) -> Iterator[None]:
    """Within, and from then on, programs are those of the files as they are now; an error brings the old ones back."""
    before = programs(ctx)
    del ctx.extra[Programs]
    try:
        yield
    except BaseException:
        ctx.extra[Programs] = before
        raise


def _key(path: str, defines: Inputs | None, virtual: Mapping[str, str] | None) -> tuple:
    if not defines and not virtual:
        return (path,)
    return path, tuple(sorted((defines or {}).items())), tuple(sorted((virtual or {}).items()))


def _compiled(compile, where_of) -> Any:
    """The result of `compile`; its error names the lines of our files."""
    try:
        return compile()
    except Exception as error:
        where: Where = where_of(str(error))
        raise ShaderError(explain(str(error), where)) from None
