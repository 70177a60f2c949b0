// Counters of the present generation of rays, and what the CPU is told of all of them at a tile's end;
// glcloth/gpu/layout.py reads the constants.
const int ONWARD = 0;         // rays of the next generation: let through,
const int MIRRORED = 1;       // and mirrored
const int WAITING = 2;        // shadow rays
const int HEADS = 3;          // heads of straight ways, of all generations so far
const int CLAIMS = 4;         // so many of which invocations claim places (inputs/tracing/claim.glsl)
const int ON_CLOTH = 4;       // rays of this generation that hit cloth,
const int ELSEWHERE = 5;      // and the others
const int RAYS = 6;           // of this generation,
const int FRONT = 7;          // so many of them at the front of its queue, the others at the very end
const int FIRST_HEAD = 8;     // that this generation casts,
const int CAST = 9;           // and how many
const int SHADOWS = 10;       // shadow rays of this generation
const int COLUMN_RAYS = 11;   // of the work groups along y that one along x stands for, where rays are shaded
// Work groups along x, y and z (glDispatchComputeIndirect),
const int RAY_GROUPS = 12;    // that sort the rays,
const int HEAD_GROUPS = 15;   // that cast the heads,
const int CLOTH_GROUPS = 18;  // that shade the hits of cloth,
const int OTHER_GROUPS = 21;  // and the others,
const int SHADOW_GROUPS = 24;  // that send the shadow rays
const int NEED_RAYS = 27;     // places that a generation lacks: it needs so many; 0: none
const int NEED_HEADS = 28;
// LOG_COUNTS for each generation: its rays, those at the front, heads cast, shadow rays, and the work groups that gather its light.
const int LOG = 29;
const int LOG_COUNTS = 7;
const int LOGS = 9;
const int COUNTS = 92;
const int GROUP = 64;         // invocations of a work group of these passes

layout(std430) buffer Counts { uint count[]; };
