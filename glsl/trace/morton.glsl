// Morton codes, and the tree that sorted codes span.   Twin: glcloth/twins/morton.py

// [Karras 2012, "Maximizing parallelism in the construction of BVHs, octrees, and k-d trees"]  Ten bits, spread to every
// third place.
uint spread_bits(uint x) {
    x = (x * 0x00010001u) & 0xFF0000FFu;
    x = (x * 0x00000101u) & 0x0F00F00Fu;
    x = (x * 0x00000011u) & 0xC30C30C3u;
    return (x * 0x00000005u) & 0x49249249u;
}

// [Karras 2012]  The 30-bit Morton code of a point of the unit cube.
uint morton_code(vec3 p) {
    uvec3 cell = uvec3(clamp(p * 1024.0, 0.0, 1023.0));
    return spread_bits(cell.x) * 4u + spread_bits(cell.y) * 2u + spread_bits(cell.z);
}

// [Karras 2012]  How many leading bits the codes at two places have in common; the places themselves part equal codes.
int common_prefix(uint code_1, uint code_2, uint place_1, uint place_2) {
    uint code = code_1 ^ code_2;
    return code != 0u ? 31 - findMSB(code) : 63 - findMSB(place_1 ^ place_2);
}
