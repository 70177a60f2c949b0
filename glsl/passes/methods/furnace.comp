#version 430
// The radiance of a fabric in a white furnace: radiance 1 from everywhere, toward a few directions.   [own]
#include "core/math.glsl"
#include "inputs/picture/fabric.glsl"
layout(local_size_x = 64) in;
uniform samplerBuffer point_data;  // omega_o of the views, then omega_i, surface frame
layout(std430) writeonly buffer Results { vec4 result[]; };
uniform int view_count;
uniform int light_count;

void main() {
    int i = int(gl_GlobalInvocationID.x);
    if (i >= view_count) return;
    vec3 omega_o = texelFetch(point_data, i).xyz;
    // Each view turns the lights by an angle of its own, so that together they fill the gaps of a narrow lobe.
    float turn = 2.0 * PI * fract(float(i) * R2.x);
    mat2 turned = mat2(cos(turn), sin(turn), -sin(turn), cos(turn));
    vec3 sum = vec3(0.0);
    float of_height = 0.0;  // luminance times cosine of the light
    for (int n = 0; n < light_count; ++n) {
        vec3 omega_i = texelFetch(point_data, view_count + n).xyz;
        omega_i.xy = turned * omega_i.xy;
        vec3 f = f_cloth(omega_i, omega_o);
        sum += f;
        of_height += dot(f, vec3(0.2126, 0.7152, 0.0722)) * omega_i.z;
    }
    result[i] = vec4(sum, of_height) * (2.0 * 3.14159265 / float(light_count));
}
