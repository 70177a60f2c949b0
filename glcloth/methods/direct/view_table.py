"""What a fabric, seen from anywhere, makes of broad light: a small table that the GPU makes anew at every edit.   [own]"""

from __future__ import annotations

from collections.abc import Callable

import moderngl
import numpy as np

from ...gpu import shader
from ...gpu.buffers import TextureBuffer
from . import broad_nodes

BASIS_UNIT, FIXED_UNIT = 11, 12  # of passes/methods/view_table.comp
BLOCK = 16  # directions that one invocation of passes/methods/view_table.comp makes


class ViewTable:
    """c_j(omega_o) = int f cos(theta_i) B_j for the directions x_j at which broad light is looked up."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.programs: dict[tuple, object] = {}
        self._fixed_data = TextureBuffer(ctx, 1 << 16)
        self._texture = self._basis_map = self._levels = None

    def use(self, unit: int) -> None:
        """Bind the table."""
        self._texture.use(unit)

    def make(self, size: int, levels: list, defines: dict, bind: Callable, record: np.ndarray) -> None:
        """Make the table.

        Parameters
        ----------
        size : texels a side, odd, so that the planes of the yarns, where upright tangents turn out of sight, lie on texels
        levels : of `broad_nodes.levels`; none: nothing is looked up, and what is there already serves
        defines : how the tangents are packed (cloth/direct.py)
        bind : gives a program the method's uniforms and the nodes of its lobes
        record : how the nodes of the fixed rule see the lobes, [3, 4]: share kept, sharpness, log2 of the amplitude
        """
        if not levels and self._texture is not None:
            return
        self._choose(levels or [(0, 1.0)])
        if self._texture is None or self._texture.width != size or self._texture.layers < self._count:
            self._texture = self._array(self._texture, size, self._count)
        key = tuple(sorted(defines.items()))
        if key not in self.programs:
            self.programs[key] = shader.compute(self.ctx, "passes/methods/view_table.comp", defines)
        program = self.programs[key]
        bind(program)
        names = ("broad_kept", "broad_sharp", "broad_height")
        values = {name: tuple(map(float, value)) for name, value in zip(names, record, strict=True)}
        shader.set_uniforms(program, fixed_count=self._fixed, block_count=self._count // BLOCK, **values)
        self._fixed_data.bind(FIXED_UNIT)
        self._basis_map.use(BASIS_UNIT)
        self._texture.bind_to_image(0, read=False, write=True)
        tiles = -(-size // 8)
        program.run(tiles, tiles, self._count // BLOCK)
        self.ctx.memory_barrier(moderngl.TEXTURE_FETCH_BARRIER_BIT)

    def _choose(self, levels: list) -> None:
        """Upload the directions' shares in light from between, where they are not there yet."""
        if levels == self._levels:
            return
        self._levels = levels
        parts = [part for _, part in levels]
        rules = [broad_nodes.fixed_rule(level) for level, _ in levels]
        weights = np.concatenate([part * rule[1] for part, rule in zip(parts, rules, strict=True)], 1)
        omega = np.pad(rules[0][0], ((0, 0), (0, 1)))
        self._fixed, self._count = weights.shape
        self._fixed_data.write(np.concatenate([omega.ravel(), weights.ravel()]).reshape(-1, 4).astype("f4"))
        maps = np.concatenate([part * broad_nodes.basis_map(level) for level, part in levels]).astype("f4")
        self._basis_map = self._array(self._basis_map, broad_nodes.BASIS_SIZE, len(maps), maps.tobytes())

    def _array(self, old, size: int, layers: int, data: bytes | None = None) -> moderngl.TextureArray:
        """A texture array in place of an old one."""
        if old is not None:
            old.release()
        texture = self.ctx.texture_array((size, size, layers), 4, data, dtype="f4")
        texture.filter = moderngl.LINEAR, moderngl.LINEAR
        texture.repeat_x = texture.repeat_y = False
        return texture
