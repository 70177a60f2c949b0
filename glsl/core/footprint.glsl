// What a pixel covers of a pattern that lies on a surface, and how a map of it is averaged there.   [own]
// Twin: glcloth/twins/footprint.py

// How far the place where the ray of direction d meets a plane of normal n moves when d changes by `change`; t: of the place,
// in lengths of d.   [own]
vec3 place_step(vec3 d, vec3 change, vec3 n, float t) {
    float facing = dot(n, d), least = 0.01 * length(d);
    // Where the plane is seen from its edge the place runs away; no pixel shows that.
    facing = facing < 0.0 ? min(facing, -least) : max(facing, least);
    return t * (change - d * (dot(n, change) / facing));
}

// How much the coordinates that a triangle interpolates change along a step in its plane; `to_b`, `to_c`: from its first corner
// to the others, uv_b and uv_c: how much the coordinates change on these ways.   [own]
vec2 uv_step(vec3 way, vec3 to_b, vec3 to_c, vec2 uv_b, vec2 uv_c) {
    vec3 n = cross(to_b, to_c);
    float n2 = max(dot(n, n), 1e-30);
    return uv_b * (dot(cross(way, to_c), n) / n2) + uv_c * (dot(cross(to_b, way), n) / n2);
}

// (taps, level): how many places on the longer side of a pixel a map is read at, and in which of its mip levels; x and y: sides
// of the pixel in texels. Own taps, because software rasterisers filter anisotropically from wrong texels.   [own]
vec2 taps_and_level(vec2 x, vec2 y, float most) {
    float a = length(x), b = length(y);
    float longer = max(a, b), shorter = max(min(a, b), 1.0);
    float taps = clamp(ceil(longer / shorter - 0.5), 1.0, most);
    return vec2(taps, 0.5 * log2(shorter * max(longer / taps, shorter)));
}

// How far the sides of warp and weft, across v and across u, turn to light from omega: -1..1.   [own, facts-weave 3]
vec2 lean(vec3 omega) {
    return clamp(omega.yx / (max(omega.z, 0.0) + 0.35), -1.0, 1.0);
}

// How far to the side, along u and v, a place of height 1 stands before the cloth seen from omega. Flat views are cut off: there
// a search of few steps would miss yarns.   [own, facts-weave 4]
vec2 relief_way(vec3 omega) { return omega.xy / max(omega.z, 0.3); }

// Values whose mean is `mean`, changed so that it is `wanted`. What is hardly ever seen is spread evenly, and not made bright
// where it is.   [own]
vec4 with_mean(vec4 value, vec4 mean, float wanted) {
    float least = 0.1 * wanted;
    return (value + max(least - mean, 0.0)) * (wanted / max(mean, least));
}

// (number of a version of a map, share of the next) that a pixel reads whose size is mip level `level`. steps: from which mip
// level, and up to which, versions are a quarter of a level apart, else a whole one; how many there are. Up to there the
// share is 0: `choice`, 0..1, decides between neighbours, each as often as it is near. See glcloth/weave/levels.py.   [own]
vec2 level_number(float level, vec3 steps, float choice) {
    float number = min(level, steps.x) + 4.0 * clamp(level - steps.x, 0.0, steps.y - steps.x) + max(level - steps.y, 0.0);
    bool one = level <= steps.y;
    float first = min(floor(one ? number + choice : number), steps.z - 1.0);
    return vec2(first, one || first == steps.z - 1.0 ? 0.0 : number - first);
}

// The mip level of a version.   [own]
float level_of_number(float number, vec3 steps) {
    float end = steps.x + 4.0 * (steps.y - steps.x);
    return min(number, steps.x) + 0.25 * clamp(number - steps.x, 0.0, end - steps.x) + max(number - end, 0.0);
}

// The place in the picture of all versions; rect: where this one begins, and its sides; place: in repeats.   [own]
vec2 place_in(vec4 rect, vec2 place) { return rect.xy + fract(place) * rect.zw; }
