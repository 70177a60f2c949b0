// Reading from the G-buffer where on which triangle a pixel lies; passes/picture/surface.frag fills it.
uniform sampler2D frame_p;
uniform sampler2D frame_b;

// Where rays of this pixel start, world space: on the curved surface that the smooth normals tell of, so that no ray
// above the smooth horizon meets the flat triangles next to it.   [Hanika 2021]
vec3 origin_at(ivec2 pixel) { return texelFetch(frame_p, pixel, 0).xyz; }

int triangle_at(ivec2 pixel) { return int(texelFetch(frame_p, pixel, 0).w); }

vec3 weights_at(ivec2 pixel) {
    vec2 b = texelFetch(frame_b, pixel, 0).xy;
    return vec3(1.0 - b.x - b.y, b);
}
