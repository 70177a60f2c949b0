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
uniform float upright;                   // how much so gathered light is given back, see glcloth/visibility/furnace.py Given
uniform bool later;                      // with a guess of later bounces
uniform vec3 passed;                     // what of the other side's light comes evenly through

// Radiance of the own light, with how upright it is, and of gathered light, which comes from all over.
vec4 both(vec4 own, vec3 gathered) {
    const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
    vec2 weights = vec2(dot(own.rgb, LUMINANCE), dot(gathered, LUMINANCE));
    return vec4(own.rgb + gathered, dot(weights, vec2(own.a, upright)) / max(weights.x + weights.y, 1e-12));
}

void main() {
    int i = item();
    if (i >= vertex_count) return;
    vec3 front = texelFetch(bounced_data, 4 * i).rgb, back = texelFetch(bounced_data, 4 * i + 2).rgb;
    float hidden = texelFetch(bounced_data, 4 * i + 1).w, hidden_back = texelFetch(bounced_data, 4 * i + 3).w;
    vec3 share = own_reflectance ? texelFetch(reflectance_data, i).rgb : reflectance;
    if (later) {
        front *= later_bounces(share + passed, hidden);
        back *= later_bounces(share + passed, hidden_back);
    }
    int at = 2 * (first_item + i);
    radiance[at] = both(texelFetch(radiance_data, at), share * front + passed * back);
    radiance[at + 1] = both(texelFetch(radiance_data, at + 1), share * back + passed * front);
}
