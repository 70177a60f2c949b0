"""What a fabric, seen from anywhere, makes of broad light: a small table that the GPU makes anew at every edit.   [own]"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np

from ...gpu.buffers import TextureBuffer
from ...gpu.memo import Last
from ...gpu.programs import Inputs, programs
from . import broad_nodes

BLOCK = 16  # directions that one invocation of passes/methods/view_table.comp makes
Levels = tuple[tuple[int, float], ...]


class ViewTable:
    """c_j(omega_o) = int f cos(theta_i) B_j for the directions x_j at which broad light is looked up."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.texture: moderngl.TextureArray | None = None
        self._basis_map: moderngl.TextureArray | None = None
        self._fixed_data = TextureBuffer(ctx, 1 << 16)
        self._chosen: Last[dict[str, Any]] = Last()

    def make(
        self,
        size: int,
        levels: Levels,
        defines: dict[str, Any],
        inputs: Inputs,
        record: np.ndarray,
        sets: Sequence[dict[str, Any]] = ({},),
    ) -> None:
        """Make the table.

        Parameters
        ----------
        size : texels a side, odd, so that the planes of the yarns, where upright tangents turn out of sight, lie on texels
        levels : of `broad_nodes.levels`; none: nothing is looked up, and what is there already serves
        defines : how the tangents are packed (Direct.variants)
        inputs : the method's uniforms and the nodes of its lobes
        record : how the nodes of the fixed rule see the lobes, [3 or more, 4]: share kept, 1 / sharp^2, amplitude / sharp
        sets : uniforms of each of several such tables, one behind the other
        """
        if not levels and self.texture is not None:
            return
        levels = levels or ((0, 1.0),)
        chosen = self._chosen.get(lambda: self._choose(levels), levels)
        blocks = chosen["block_count"]
        if self.texture is None or self.texture.width != size or self.texture.layers < BLOCK * blocks * len(sets):
            self.texture = self._array(self.texture, size, BLOCK * blocks * len(sets))
        names = ("broad_kept", "broad_spread", "broad_amplitude")
        lobes = dict(zip(names, record[:3], strict=True))
        program = programs(self.ctx).compute("passes/methods/view_table.comp", defines)
        for number, own in enumerate(sets):
            program.run(
                (size, size, blocks), inputs, chosen, lobes, own,
                first_layer=number * BLOCK * blocks, basis_map=self._basis_map, view_table=self.texture,
            )  # fmt: skip

    def _choose(self, levels: Levels) -> dict[str, Any]:
        """Upload the directions' shares in light from between."""
        rules = [broad_nodes.fixed_rule(level) for level, _ in levels]
        weights = np.concatenate([part * rule[1] for (_, part), rule in zip(levels, rules, strict=True)], 1)
        omega = np.pad(rules[0][0], ((0, 0), (0, 1)))
        self._fixed_data.write(np.concatenate([omega.ravel(), weights.ravel()]).reshape(-1, 4).astype("f4"))
        maps = np.concatenate([part * broad_nodes.basis_map(level) for level, part in levels]).astype("f4")
        self._basis_map = self._array(self._basis_map, broad_nodes.BASIS_SIZE, len(maps), maps.tobytes())
        fixed, count = weights.shape
        return {"fixed_nodes": self._fixed_data, "fixed_count": fixed, "block_count": count // BLOCK}

    def _array(
        self, old: moderngl.TextureArray | None, size: int, layers: int, data: bytes | None = None
    ) -> moderngl.TextureArray:
        """A texture array in place of an old one."""
        if old is not None:
            old.release()
        texture = self.ctx.texture_array((size, size, layers), 4, data, dtype="f4")
        texture.filter = moderngl.LINEAR, moderngl.LINEAR
        texture.repeat_x = texture.repeat_y = False
        return texture

    def release(self) -> None:
        """Free the GPU's memory."""
        self._fixed_data.release()
        for texture in (self.texture, self._basis_map):
            if texture is not None:
                texture.release()
