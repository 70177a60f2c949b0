// What comes through cloth from its other side, but for what goes straight on: "behind.glsl" of methods direct and paper.
//   T_lambert E / pi, E from Gaussians and the bounce; suns by all that the yarns pass, for a sun is no background.
#include "inputs/picture/lights.glsl"
#include "inputs/visibility/irradiance_table.glsl"
uniform usamplerBuffer mean_data;      // passes/visibility/spread.comp
uniform samplerBuffer bounced_data;    // passes/visibility/bounce_spread.comp
uniform isamplerBuffer drawn_corners;  // three a triangle
uniform sampler2DArray seen_behind;    // passes/visibility/suns_behind.comp: a layer for each sun
uniform int group_count;               // of mean_data
uniform bool sees_gaussians;  // all of each; else as mean_data says
uniform bool sees_suns;       // likewise
uniform sampler2DArray seen;          // of the side that is seen: V_0, V_1 .. V_K, four a texel
uniform sampler2DArray bounced_light;  // passes/visibility/bounce_pixels.comp
uniform bool gathers;         // bounced_data holds the bounced light

vec3 weights;
ivec3 corners;  // twice the vertex, 1 more for its back

float V_behind(int n) {
    int group = n >> 2, at = n & 3;
    return weights.x * unpackUnorm4x8(texelFetch(mean_data, corners.x * group_count + group).x)[at]
        + weights.y * unpackUnorm4x8(texelFetch(mean_data, corners.y * group_count + group).x)[at]
        + weights.z * unpackUnorm4x8(texelFetch(mean_data, corners.z * group_count + group).x)[at];
}

vec3 L_behind(ivec2 pixel, vec3 omega_o, mat3 surface_from_world) {
    int first = 3 * triangle_at(pixel);
    corners = 2 * ivec3(texelFetch(drawn_corners, first).x, texelFetch(drawn_corners, first + 1).x,
        texelFetch(drawn_corners, first + 2).x) + (texelFetch(frame_x, pixel, 0).w < 0.0 ? 0 : 1);
    weights = weights_at(pixel);
    vec3 N = vec3(surface_from_world[0].z, surface_from_world[1].z, surface_from_world[2].z);
    vec3 E = vec3(0.0), L = vec3(0.0);
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        float V = sees_gaussians ? 1.0 : V_behind(1 + k);
        E += light.L * (V * gaussian_irradiance(k, -dot(N, light.xi)));
    }
    for (int s = 0; s < sun_count; ++s) {
        Sun sun = fetch_sun(s);
        vec3 omega_i = surface_from_world * sun.omega;
        if (omega_i.z >= 0.0) continue;
        // The functions have z = N on the light's side.
        vec3 i_t = vec3(omega_i.xy, -omega_i.z), o_t = vec3(omega_o.xy, -omega_o.z);
        vec3 light = sees_suns ? sun.E : sun.E * texelFetch(seen_behind, ivec3(pixel, s), 0).rgb;
        L += light * absorption(i_t, o_t, tau)
            * f_through(i_t, o_t, k_t, rho, roughness, eta_1, eta_2, diffuse, roughness_p);
    }
    E = max(E, vec3(0.0));
    if (gathers) {
        ivec3 at = 2 * corners;
        E += PI * (weights.x * texelFetch(bounced_data, at.x).rgb + weights.y * texelFetch(bounced_data, at.y).rgb
            + weights.z * texelFetch(bounced_data, at.z).rgb);
    }
    return L + T_lambert(omega_o, k_t, tau, rho, diffuse) / PI * E;
}

// Radiance of the Gaussians, as far as the pixel sees them, along omega_i (surface frame, z > 0), and of what hides them, as far
// as it is known: in the mean. Suns have their lobes.
vec3 L_mirrored(ivec2 pixel, vec3 omega_i, mat3 surface_from_world) {
    vec3 omega = omega_i * surface_from_world, L = vec3(0.0);
    for (int k = 0; k < gaussian_count; ++k) {
        Gaussian light = fetch_gaussian(k);
        float V = sees_gaussians ? 1.0 : texelFetch(seen, ivec3(pixel, (1 + k) >> 2), 0)[(1 + k) & 3];
        L += light.L * (V * exp(light.sharpness * (dot(omega, light.xi) - 1.0)));
    }
    return max(L, vec3(0.0)) + (gathers ? texelFetch(bounced_light, ivec3(pixel, 0), 0).rgb : vec3(0.0));
}
