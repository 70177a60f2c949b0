// A hit on the finer triangles of passes/visibility/finer.comp as one on the triangle that they were cut from.
// Needs struct Visit from the pass that includes it.
#include "trace/smooth.glsl"
uniform int finer_levels;     // 0: triangles are as they were
uniform int finer_triangles;  // so many, from the first on, were cut

Visit coarse(Visit visit) {
    int whole = finer_triangles << (2 * finer_levels), t = int(visit.triangle & 0x7fffffffu);
    if (finer_levels == 0 || t >= 0x7fffffff) return visit;
    if (t >= whole) return Visit(visit.t, uint(t - whole + finer_triangles), visit.weights);
    vec3 w = vec3(1.0 - visit.weights.x - visit.weights.y, visit.weights);
    int level = 0;
    do {
        w = weights_of_whole(w, t & 3);
        t >>= 2;
    } while (++level < finer_levels);
    return Visit(visit.t, uint(t), w.yz);
}
