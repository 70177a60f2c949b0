#version 430
// The environment behind the cloth: an equirectangular map, +Y up, as glcloth/light/equirect.py maps directions.
#include "core/equirect.glsl"
uniform sampler2D environment_map;
uniform mat3 ray_from_pixel;
uniform mat3 environment_from_world;
uniform float weight;  // share of the picture
out vec4 color;

void main() {
    vec3 omega = normalize(environment_from_world * (ray_from_pixel * vec3(gl_FragCoord.xy, 1.0)));
    color = vec4(textureLod(environment_map, uv_from_direction(omega), 0.0).rgb * weight, 0.0);
}
