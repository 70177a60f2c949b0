"""A plane without end under a hierarchy of triangles: it needs no triangles, and no traversal where it hides the light."""

from __future__ import annotations

from ..gpu import shader


class OverGround:
    """An `Lbvh` and the plane y = height, which is met from both sides; to passes that trace it is one structure.

    What meets the plane has the number GROUND of inputs/accel/lbvh_ground.glsl.
    """

    source = "inputs/accel/lbvh_ground.glsl"
    settles = False

    def __init__(self, structure, height: float):
        self.structure, self.height = structure, float(height)

    def inputs(self) -> dict:
        """What inputs/accel/lbvh_ground.glsl reads."""
        return self.structure.inputs() | {"ground_height": self.height}

    def bind(self, program) -> None:
        """Bind what inputs/accel/lbvh_ground.glsl reads."""
        self.structure.bind(program)
        shader.set_uniforms(program, ground_height=self.height)

    @property
    def triangles(self):
        """What the structure was built of."""
        return self.structure.triangles

    def chunks(self):
        """The uniforms of each dispatch that one query takes."""
        return self.structure.chunks()
