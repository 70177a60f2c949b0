// The nearest points of a kd-tree of points that lie on the same surface, and the mean of what they carry.   [Zhou 2008, 4.2]
// The radius that holds `nearest_wanted` of them is found by a histogram over the squared radius: each search shrinks its
// reach as soon as enough lie within, and is made again within it until a bin is thin. So any number can be asked for, and
// an invocation keeps BINS numbers instead of a heap.
#include "trace/shared.glsl"
#include "trace/octahedron.glsl"
#include "trace/photons.glsl"

uniform usamplerBuffer point_nodes;   // passes/accel/kdtree_emit.comp says how they are packed
uniform usamplerBuffer leaf_points;   // two texels: (x, y, z, packed normal) (what it carries, its place or its area)
uniform int nearest_wanted;
uniform float nearest_most;           // the largest squared radius, but where there is nothing within

const int BINS = 32;
const int SEARCHES = 6;     // at most, before the one that sums
const float WIDER = 16.0;   // where nothing was found
const int THIN = 16;        // the radius is found where so many bins lie within
const float AGREE = 0.7;    // cosine between normals of one surface
const uint NO_NODE = 0xffffffffu;

struct Search {
    vec3 p;
    vec3 n;
    float reach;   // squared
    float per_bin; // bins a squared radius
    int limit;     // the last bin within reach
    uint within;   // points in these
    bool counts;   // instead of summing
    bool by_area;  // what is summed weighs by the area that it stands for
    vec3 sum;
    float weight;
};

uint nearest_bins[BINS];

// Of a leaf's points the one at i, which is there before `last`.
void meet_point(inout Search search, int i, int last) {
    uvec4 place = texelFetch(leaf_points, 2 * min(i, last - 1));
    float d2 = disc_distance(uintBitsToFloat(place.xyz) - search.p, search.n);
    // A point tells nothing of the density at its own place.
    if (i >= last || d2 <= 0.0 || d2 >= search.reach) return;
    if (dot(from_octahedral(unpackSnorm2x16(place.w)), search.n) <= AGREE) return;
    if (search.counts) {
        ++nearest_bins[min(int(d2 * search.per_bin), BINS - 1)];
        ++search.within;
        bool less = search.limit > 0 && search.within - nearest_bins[search.limit] >= uint(nearest_wanted);
        while (less) {
            search.within -= nearest_bins[search.limit];
            --search.limit;
            search.reach = float(search.limit + 1) / search.per_bin;
            less = search.limit > 0 && search.within - nearest_bins[search.limit] >= uint(nearest_wanted);
        }
    } else {
        vec4 carried = uintBitsToFloat(texelFetch(leaf_points, 2 * i + 1));
        float weight = disc_kernel(d2, search.reach) * (search.by_area ? carried.w : 1.0);
        search.sum += weight * carried.xyz;
        search.weight += weight;
    }
}

void search_points(inout Search search) {
    uint waiting[STACK];
    float waiting_d2[STACK];
    int top = 0;
    uint at = 0u;
    do {
        uvec2 node = texelFetch(point_nodes, int(at)).xy;
        bool inner = (node.y & 3u) != 3u;
        // Tests stand at the end, as in inputs/accel/kdtree.glsl.
        do {
            if (inner) {
                uint axis = node.y & 3u;
                float delta = (axis == 0u ? search.p.x : axis == 1u ? search.p.y : search.p.z) - uintBitsToFloat(node.x);
                uint right = node.y >> 2;
                bool is_left = delta <= 0.0;
                // Written in any case, and kept only if `top` moves on.
                waiting[top] = is_left ? right : at + 1u;
                waiting_d2[top] = delta * delta;
                top += delta * delta < search.reach ? 1 : 0;
                at = is_left ? at + 1u : right;
                node = texelFetch(point_nodes, int(at)).xy;
                inner = (node.y & 3u) != 3u;
            }
        } while (inner);
        int i = int(node.x);
        int last = int(node.x + (node.y >> 2));
        // By fours: llvmpipe ends an invocation's loops after 65,535 rounds together.
        do {
            if (i < last) {
                meet_point(search, i, last);
                meet_point(search, i + 1, last);
                meet_point(search, i + 2, last);
                meet_point(search, i + 3, last);
            }
            i += 4;
        } while (i < last);
        at = NO_NODE;
        bool back = top > 0;
        do {
            top -= back ? 1 : 0;
            bool found = back && waiting_d2[top] < search.reach;
            at = found ? waiting[top] : at;
            back = back && !found && top > 0;
        } while (back);
    } while (at != NO_NODE);
}

Search begun(vec3 p, vec3 n, float reach, bool counts) {
    return Search(p, n, reach, 0.0, 0, 0u, counts, false, vec3(0.0), 0.0);
}

// Searches once, and shrinks the reach to what holds the wanted points; true where another search is needed to know it well.
bool shrinks(inout Search search) {
    for (int k = 0; k < BINS; ++k) nearest_bins[k] = 0u;
    search.per_bin = float(BINS) / search.reach;
    search.limit = BINS - 1;
    search.within = 0u;
    search_points(search);
    bool empty = search.within == 0u;
    search.reach *= empty ? WIDER : 1.0;
    return empty || search.within >= uint(nearest_wanted) && search.limit < THIN;
}

// The mean of what points carry about p on a surface with the normal n, each by the area that it stands for: where they lie
// densely, they would count too often. By all searches at once: for few points.
vec3 nearest_mean(vec3 p, vec3 n) {
    Search search = begun(p, n, nearest_most, true);
    search.by_area = true;
    int searches = 0;
    bool more = true;
    do {
        bool again = shrinks(search);
        ++searches;
        more = search.counts;
        search.counts = search.counts && again && searches < SEARCHES;
    } while (more);
    return search.sum / max(search.weight, 1e-30);
}
