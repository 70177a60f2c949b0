// A ground of which only the shadow is seen: black, as much of it as the light that is hidden there.   [own]
uniform int first_catching;     // from this triangle on only the shadow is shown,
uniform vec2 catcher_middle;    // x and z,
uniform vec2 catcher_fade;      // and from this distance on less of it, to that one
uniform float open_luminance;   // of the irradiance where nothing hides light

vec4 caught(ivec2 pixel, float pass_weight) {
    float shown = 1.0 - smoothstep(catcher_fade.x, catcher_fade.y, length(origin_at(pixel).xz - catcher_middle));
    float hidden = dot(E_hidden, vec3(0.2126, 0.7152, 0.0722)) / open_luminance;
    return vec4(vec3(0.0), clamp(hidden, 0.0, 1.0) * shown * pass_weight);
}
