// A hair that stands out from cloth, and how much of a pixel it covers.
// Twin: glcloth/twins/hair.py

// Where a hair is, in its lengths: along x and y of the surface frame, and off the cloth; s: 0 at its root, 1 at its end. `way`
// and `bend` are eight random numbers from 0 to 1.   [own]
vec3 hair_place(vec4 way, vec4 bend, float s) {
    float turn = 6.2831853 * way.x, up = mix(0.12, 0.95, way.y), out_by = sqrt(1.0 - up * up);
    vec3 first = vec3(out_by * cos(turn), out_by * sin(turn), up);
    vec3 second = vec3(1.3 * (bend.xy - 0.5), -0.75 * way.z * up);
    vec3 third = vec3(1.1 * (bend.zw - 0.5), 0.45 * (way.w - 0.5));
    vec3 place = s * (first + s * (second + s * third));
    return vec3(place.xy, max(place.z, 0.02 * s));
}

// How much of a pixel a straight line covers whose middle passes it at distance x; x and width in pixels. Over x its integral is
// the width, however thin it is.   [own]
float hair_cover(float x, float width) {
    return clamp(0.5 * width + 0.5 - abs(x), 0.0, min(width, 1.0));
}

// How much of the light from omega reaches a hair on cloth of normal N: none from below, where cloth is. `soft`: as sine, how
// wide the light is.   [own]
float hair_horizon(vec3 N, vec3 omega, float soft) {
    return smoothstep(-soft, soft, dot(N, omega));
}
