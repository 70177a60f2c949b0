// The box of what a key stands for: a triangle, or with PIECES a part of a long thin one. See glcloth/accel/needles.py.
uniform usamplerBuffer corners;
#ifdef PIECES
uniform usamplerBuffer pieces;  // triangle, corner at its sharp end, from where to where along it
#endif

vec3 corner_at(int triangle, int k) { return uintBitsToFloat(texelFetch(corners, 3 * triangle + k).xyz); }

void key_box(int key, out vec3 low, out vec3 high) {
#ifdef PIECES
    uvec4 piece = texelFetch(pieces, key);
    int triangle = int(piece.x), k = int(piece.y);
    vec2 ends = uintBitsToFloat(piece.zw);
    vec3 a = corner_at(triangle, k), b = corner_at(triangle, (k + 1) % 3) - a, c = corner_at(triangle, (k + 2) % 3) - a;
    low = a + min(min(ends.x * b, ends.y * b), min(ends.x * c, ends.y * c));
    high = a + max(max(ends.x * b, ends.y * b), max(ends.x * c, ends.y * c));
#else
    vec3 a = corner_at(key, 0), b = corner_at(key, 1), c = corner_at(key, 2);
    low = min(a, min(b, c));
    high = max(a, max(b, c));
#endif
}
