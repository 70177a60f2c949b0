// Reading the G-buffer that passes/picture/surface.frag fills, and the rays of the camera.
uniform sampler2D frame_N;
uniform sampler2D frame_x;
uniform mat3 ray_from_pixel;  // direction of a ray = ray_from_pixel * (pixel centre x, y from below, 1), not unit

ivec2 shaded_pixel;  // the one whose L_o is asked for, for methods that cast rays from it

// The rows x, y, N.
mat3 surface_from_world_at(ivec2 pixel) {
    vec4 N = texelFetch(frame_N, pixel, 0);
    vec3 x = texelFetch(frame_x, pixel, 0).xyz;
    vec3 y = N.w * cross(N.xyz, x);
    return transpose(mat3(x, y, N.xyz));
}

vec3 omega_o_at(vec2 centre) {
    return -normalize(ray_from_pixel * vec3(centre, 1.0));
}
