// Visibility of a point's surroundings.   Twin: glcloth/twins/visibility.py

// [own]  How much a direction of the cosine z belongs to the horizon, to the band above it and to the top; they sum to 1.
vec3 band_shares(float z) {
    float low = clamp(1.0 - 2.5 * z, 0.0, 1.0);
    float top = clamp((z - 0.4) / 0.6, 0.0, 1.0);
    return vec3(low, 1.0 - low - top, top);
}

// [own]  How much a direction of a surface frame belongs to +x, +y, -x, -y; they sum to 1, but for the pole.
vec4 quadrant_shares(vec3 omega) {
    vec2 shares = omega.xy * omega.xy / max(dot(omega.xy, omega.xy), 1e-12);
    return vec4(omega.x > 0.0 ? shares.x : 0.0, omega.y > 0.0 ? shares.y : 0.0,
        omega.x > 0.0 ? 0.0 : shares.x, omega.y > 0.0 ? 0.0 : shares.y);
}

// [own]  A value over the directions of a surface frame from its means toward +x, +y, -x, -y in two bands and at the top.
float from_bands(vec3 omega, vec4 low, vec4 middle, float top) {
    vec3 bands = band_shares(omega.z);
    return dot(quadrant_shares(omega), bands.x * low + bands.y * middle) + bands.z * top;
}

// [own]  What cloth gives back of a beam, over its albedo, by the cosine of the beam on this side (above 0) and on the other
// one: a share of it is flat in the cosine up to the horizon, where a Lambertian (`flat_share` 0) follows the cosine.
vec2 response_to(float cos_theta, float flat_share) {
    vec2 z = max(vec2(cos_theta, -cos_theta), 0.0);
    return flat_share * min(100.0 * z, 1.0) + (1.0 - 2.0 * flat_share) * z;
}

// [own]  All later bounces over the first, between surfaces like this one: 1 + (albedo hidden) + (albedo hidden)^2 + ..., where a
// share of the light about it is `hidden`.
vec3 later_bounces(vec3 albedo, float hidden) {
    return 1.0 / (1.0 - clamp(albedo * hidden, vec3(0.0), vec3(0.95)));
}

// [own]  The seen part and the whole (>= 0), four times, in a word each: the share in the low 16 bits, and in
// the high ones the whole as a cut float, which weights the shares of several probes.
uvec4 packed_sums(vec4 seen, vec4 all) {
    vec4 share = mix(vec4(1.0), seen / max(all, 1e-30), greaterThan(all, vec4(1e-30)));
    // By way of int: a driver may have no fast way from float to uint and back.
    return uvec4(ivec4(65535.0 * share + 0.5)) | (floatBitsToUint(all) + 0x8000u & 0xffff0000u);
}

// [own]  The whole of such words.
vec4 all_of_sums(uvec4 sums) {
    return uintBitsToFloat(sums & 0xffff0000u);
}

// [own]  65535 times the seen part.
vec4 seen_of_sums(uvec4 sums) {
    return all_of_sums(sums) * vec4(ivec4(sums & 0xffffu));
}
