#version 430
// Radiance that vertices send back, front and back, of their own light and of all the bounced light that they get.   [own]
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "trace/visibility.glsl"
uniform samplerBuffer radiance_data;     // passes/visibility/bounce_radiance.comp: of a vertex front and back
uniform samplerBuffer bounced_data;      // passes/visibility/bounce_spread.comp, of these vertices
uniform samplerBuffer reflectance_data;  // likewise, if `own_reflectance`
layout(std430) writeonly buffer Radiance { vec4 radiance[]; };  // of a vertex front and back
uniform int first_item;                  // vertex
uniform int vertex_count;                // from there on, and from the beginning of bounced_data and reflectance_data
uniform bool own_reflectance;
uniform vec3 reflectance;                // else
uniform vec3 passed;                     // what of the other side's light comes evenly through

void main() {
    int i = item();
    if (i >= vertex_count) return;
    vec3 front = texelFetch(bounced_data, 4 * i).rgb, back = texelFetch(bounced_data, 4 * i + 2).rgb;
    float hidden = texelFetch(bounced_data, 4 * i + 1).w, hidden_back = texelFetch(bounced_data, 4 * i + 3).w;
    vec3 share = own_reflectance ? texelFetch(reflectance_data, i).rgb : reflectance;
    front *= later_bounces(share + passed, hidden);
    back *= later_bounces(share + passed, hidden_back);
    int at = 2 * (first_item + i);
    radiance[at] = texelFetch(radiance_data, at) + vec4(share * front + passed * back, 0.0);
    radiance[at + 1] = texelFetch(radiance_data, at + 1) + vec4(share * back + passed * front, 0.0);
}
