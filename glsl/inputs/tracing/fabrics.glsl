// Several fabrics in one scene: what is uniform for one alone belongs here to the fabric of the triangle at hand.
// Define: FABRICS, how many, where this file is included. glcloth/tracing/fabrics.py fills the buffers: FABRIC_ROWS texels a
// fabric, and in fabric_data the records of inputs/picture/fabric.glsl, fabric_stride texels a fabric.
uniform samplerBuffer fabric_rows;
uniform ivec4 fabric_from;  // the first triangle of the second fabric, of the third, of the fourth; the last of all

uniform int fabric_stride;

const int FABRIC_ROWS = 5;

float rho = 0.0, k_a = 0.0, k_t = 0.0, diffuse = 0.0, straight_share = 0.0;
vec3 tau = vec3(0.0);
float roughness = 0.1, eta_1 = 1.0, eta_2 = 1.0, roughness_p = 0.1;
vec3 cloth_albedo = vec3(0.0);
float reflection_limit = 1.0;
ivec2 tangent_count = ivec2(0);
float sigma_mask = 1.0, gap = 0.0;
int fabric_number = 0;
int fabric_first = 0;  // its texel in fabric_data

void take_fabric(int triangle) {
    int number = fabric_number = int(triangle >= fabric_from.x) + int(triangle >= fabric_from.y) + int(triangle >= fabric_from.z);
    int first = FABRIC_ROWS * number;
    vec4 p = texelFetch(fabric_rows, first), q = texelFetch(fabric_rows, first + 1), r = texelFetch(fabric_rows, first + 2);
    vec4 s = texelFetch(fabric_rows, first + 3), t = texelFetch(fabric_rows, first + 4);
    rho = p.x; k_a = p.y; k_t = p.z; diffuse = p.w;
    tau = q.xyz; straight_share = q.w;
    roughness = r.x; eta_1 = r.y; eta_2 = r.z; roughness_p = r.w;
    cloth_albedo = s.rgb; reflection_limit = s.w;
    tangent_count = ivec2(t.xy); sigma_mask = t.z; gap = t.w;
    fabric_first = fabric_stride * number;
}
