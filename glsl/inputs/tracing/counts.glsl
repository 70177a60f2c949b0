// Counters of one generation of rays; glcloth/gpu/layout.py reads the constants.
const int ONWARD = 0;        // rays of the next generation: let through,
const int MIRRORED = 1;      // and mirrored
const int WAITING = 2;       // shadow rays
const int HEADS = 3;         // heads of straight ways, of all generations so far
const int READ_COUNTS = 4;   // so many the CPU reads
const int ON_CLOTH = 4;      // rays of this generation that hit cloth,
const int ELSEWHERE = 5;     // and the others
const int CLOTH_GROUPS = 6;  // work groups that shade either, along x, y and z (glDispatchComputeIndirect)
const int OTHER_GROUPS = 9;
const int COUNTS = 12;
const int GROUP = 64;        // rays of a work group of passes/tracing/shade.comp

layout(std430) buffer Counts { uint count[]; };
