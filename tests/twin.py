"""Call one GLSL library function on arrays, through a generated compute kernel."""

import re

import numpy as np

from glcloth.files import GLSL
from glcloth.gpu.buffers import Buffer
from glcloth.gpu.programs import Programs

# Of std430 arrays, in 4-byte words.
STRIDE = {
    "float": 1,
    "int": 1,
    "uint": 1,
    "vec2": 2,
    "vec3": 4,
    "vec4": 4,
    "uvec2": 2,
    "uvec3": 4,
    "uvec4": 4,
    "mat3": 12,
    "mat2x4": 8,
    "mat3x2": 6,
    "mat4": 16,
}
SIZE = {
    "float": 1,
    "int": 1,
    "uint": 1,
    "vec2": 2,
    "vec3": 3,
    "vec4": 4,
    "uvec2": 2,
    "uvec3": 3,
    "uvec4": 4,
    "mat3": 9,
    "mat2x4": 8,
    "mat3x2": 6,
    "mat4": 16,
}
_FUNCTION = re.compile(r"^(float|int|uint|vec[234]|uvec[234]|mat3x2|mat3|mat2x4|mat4)\s+(\w+)\s*\(([^)]*)\)\s*\{", re.M)


def functions(path):
    """{name: (return type, [(type, parameter), ...])} of one GLSL file, includes not followed."""
    text = re.sub(r"//.*", "", (GLSL / path).read_text(encoding="utf-8"))
    found = {}
    for kind, name, parameters in _FUNCTION.findall(text):
        assert name not in found, f"{path}: {name} is overloaded; a twin needs one name per function"
        found[name] = (kind, [tuple(p.split()[-2:]) for p in parameters.split(",") if p.strip()])
    return found


def call(ctx, path, name, *args):
    """Results [N] or [N, n] of a function of glsl/<path> for arguments of N rows each."""
    kind, parameters = functions(path)[name]
    count = max(np.shape(a)[0] for a in args)
    declarations, loads, buffers = [], [], []
    for i, ((t, parameter), a) in enumerate(zip(parameters, args, strict=True)):
        assert t in SIZE, f"{path}: {name}: cannot pass a {t}"
        declarations.append(f"layout(std430) readonly buffer B{i} {{ {t} in_{parameter}[]; }};")
        loads.append(f"in_{parameter}[i]")
        data = np.zeros((count, STRIDE[t]), {"i": "i4", "u": "u4"}.get(t[0], "f4"))
        values = np.asarray(a).reshape(count, SIZE[t])
        if t == "mat3":  # row-major outside, column-major with padded columns inside
            data.reshape(count, 3, 4)[:, :, :3] = values.reshape(count, 3, 3).transpose(0, 2, 1)
        else:
            data[:, : SIZE[t]] = values
        buffers.append(Buffer(ctx, data))
    result = Buffer(ctx, 4 * count * STRIDE[kind])
    kernel = "\n".join(
        [
            "#version 430",
            "layout(local_size_x = 64) in;",
            f'#include "{path}"',
            *declarations,
            f"layout(std430) writeonly buffer Out {{ {kind} results[]; }};",
            "void main() {",
            "    uint i = gl_GlobalInvocationID.x;",
            f"    if (i < {count}u) results[i] = {name}({', '.join(loads)});",
            "}",
        ]
    )
    program = Programs(ctx).compute("<twin>", None, {"<twin>": kernel})
    try:
        program.run(count, {f"B{i}": buffer for i, buffer in enumerate(buffers)}, Out=result)
        data = np.frombuffer(result.read(), {"i": "i4", "u": "u4"}.get(kind[0], "f4")).reshape(count, STRIDE[kind])
    finally:
        program.release()
        for buffer in [*buffers, result]:
            buffer.release()
    if kind == "mat3":
        return data.reshape(count, 3, 4)[:, :, :3].transpose(0, 2, 1).copy()
    return data[:, 0].copy() if SIZE[kind] == 1 else data[:, : SIZE[kind]].copy()
