#version 430
// The radiance of a fabric in a white furnace toward a grid of views, and how much it follows the direction of the light.   [own]
#include "core/math.glsl"
#include "inputs/picture/fabric.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform samplerBuffer point_data;  // omega_i, evenly over the hemisphere, surface frame
layout(rgba16f) writeonly uniform image2DArray views;  // azimuth, cosine; radiance and x | y, z of its first moment
uniform int light_count;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(views).xy;
    if (any(greaterThanEqual(texel, size))) return;
    float z = (float(texel.y) + 0.5) / float(size.y), phi = 2.0 * PI * (float(texel.x) + 0.5) / float(size.x);
    vec3 omega_o = vec3(sqrt(1.0 - z * z) * vec2(cos(phi), sin(phi)), z);
    // Each view turns the lights by an angle of its own, so that together they fill the gaps of a narrow lobe.
    float turn = 2.0 * PI * fract(float(texel.x + size.x * texel.y) * R2.x);
    mat2 turned = mat2(cos(turn), sin(turn), -sin(turn), cos(turn));
    vec3 sum = vec3(0.0);
    vec3 moment = vec3(0.0);
    for (int n = 0; n < light_count; ++n) {
        vec3 omega_i = texelFetch(point_data, n).xyz;
        omega_i.xy = turned * omega_i.xy;
        vec3 f = f_cloth(omega_i, omega_o);
        sum += f;
        moment += dot(f, vec3(0.2126, 0.7152, 0.0722)) * omega_i;
    }
    // f as far as it is linear in the direction: least squares, its mean times 1 + 3 (x, y) . (x, y) + 12 z (z - 1/2), with
    // the moments x, y, z - 1/2.
    moment /= max(dot(sum, vec3(0.2126, 0.7152, 0.0722)), 1e-12);
    moment = vec3(3.0 * moment.xy, 12.0 * (moment.z - 0.5));
    imageStore(views, ivec3(texel, 0), vec4(sum * (2.0 * PI / float(light_count)), moment.x));
    imageStore(views, ivec3(texel, 1), vec4(moment.yz, 0.0, 0.0));
}
