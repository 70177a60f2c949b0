// Threads where a path from the eye first meets woven cloth: by the maps of inputs/methods/weave.glsl, as the other methods have
// them. Everywhere else, and for other fabrics than the one of this dispatch, all places are alike.   [own]
// Defines: WEAVE and its kin. glcloth/tracing/path_threads.py fills the buffer.
#include "inputs/methods/weave.glsl"
uniform samplerBuffer thread_rows;  // of each fabric: the dispatch that shows its threads (-1: none), metres in a UV unit
uniform int dispatch;               // of those, each of another fabric, that together have all samples

ivec2 reads_as;        // the pixel of 4 x 4, each of which reads other versions of the maps: here each sample of 16 does
bool at_threads = false;
float covering = 1.0;  // yarns of the place, over the mean
int claimed = -1;      // the dispatch that a sample belongs to; -1: to the first

void leave_threads() {
    at_threads = false;
    covering = 1.0;
    strands = vec4(1.0);
}

// How much of a tangent the place shows, and its side.
vec2 seen_tangent(int t) { return at_threads ? rel_and_turn(t) : vec2(1.0, 0.0); }

// A path from the eye meets cloth: whether this dispatch has its sample.
bool claims(int cloth) {
    int own = int(texelFetch(thread_rows, cloth).x);
    claimed = claimed < 0 ? own : claimed;
    return claimed < 0 || claimed == dispatch;
}

// Take the place of a hit of cloth whose colours are multiplied by `tint`; `d`: of the pixel's ray, 1 along the view; t: in
// lengths of it, 1 of parallel rays.
void come_to_threads(int cloth, int triangle, vec2 at, vec3 tint, vec3 d, float t) {
    vec4 row = texelFetch(thread_rows, cloth);
    if (int(row.x) != dispatch) return;
    ivec3 v = ivec3(texelFetch(hit_corners, 3 * triangle).x, texelFetch(hit_corners, 3 * triangle + 1).x,
        texelFetch(hit_corners, 3 * triangle + 2).x);
    vec3 a = texelFetch(hit_vertices, 3 * v.x).xyz;
    vec3 b = texelFetch(hit_vertices, 3 * v.y).xyz - a, c = texelFetch(hit_vertices, 3 * v.z).xyz - a;
    vec2 uv = row.y * texelFetch(surface_uv, v.x).xy;
    vec2 uv_b = row.y * texelFetch(surface_uv, v.y).xy - uv, uv_c = row.y * texelFetch(surface_uv, v.z).xy - uv;
    place_of_path = uv_footprint(b, c, uv, uv_b, uv_c, vec3(1.0 - at.x - at.y, at), d, t);
    fetch_weave(reads_as);
    pixel_A[0] *= tint;
    pixel_A[1] *= tint;
    at_threads = true;
}
