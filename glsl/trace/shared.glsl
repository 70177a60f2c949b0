// Constants that the ray tracer's passes and glcloth/curtain share; read by glcloth/gpu/layout.py.

// Counters of a build, one uint each.
const int NODE_COUNT = 0;        // nodes made so far
const int ROOT_COUNT = 1;        // small roots
const int SMALL_REF_COUNT = 2;   // references in small roots
const int ACTIVE_COUNT = 3;      // nodes of the next level
const int NEXT_REF_COUNT = 4;    // references of the next level
const int NEED_NODES = 5;        // set when a buffer was too small
const int NEED_REFS = 6;
const int LEAF_REF_COUNT = 7;    // references in leaves
const int LONGEST_LEAF_COUNT = 8;  // triangles of the longest leaf that could not be split
const int NEED_LANES = 9;
const int NEED_LEAF_REFS = 10;
const int ACTIVE_NOW = 11;       // large nodes of this level,
const int LANES_NOW = 12;        // and the invocations that share each
const int LARGE_USED = 13;       // levels that had large nodes
const int ACTIVE_MOST = 14;      // references of the largest node of the next level
const int ROOT_BOX = 16;         // six floats, when the tree is written
// Work groups along x, y and z of the passes that are dispatched by them.
const int LANE_GROUPS = 24;      // of measure and scatter
const int NODE_GROUPS = 27;      // of divide
const int MASK_GROUPS = 30;
const int EMIT_GROUPS = 33;
const int LEAF_GROUPS = 36;
const int GENERATIONS = 40;      // where each begins among the nodes, as far as the first of small nodes
const int SMALL_ACTIVE = 72;     // small nodes of each level,
const int SMALL_GROUPS = 96;     // and their work groups, three numbers a level
const int COUNTERS = 168;
const int NODE_GROUP = 64;       // invocations of a work group of the passes above, but for that of masks

// Kinds of a node under construction.
const uint PENDING = 0u;
const uint INNER = 1u;
const uint SMALL_LEAF = 2u;      // its triangles are the bits of a mask over its small root's
const uint EMPTY_LEAF = 3u;
const uint LARGE_LEAF = 4u;      // its triangles are a range of references: it could not be split

const uint NO_TRIANGLE = 0xffffffffu;
const uint SOLID = 0x80000000u;  // beside a triangle's number: it is not cloth
const int BLOCK_WIDTH = 2;       // pixels whose rays a SIMD vector of eight takes together
const int BLOCK_HEIGHT = 4;
const int PART_SHARE = 32;       // rays that an invocation of passes/tracing/sort.comp takes
const int STACK = 48;            // the deepest a tree may be: LARGE_LEVELS + SMALL_LEVELS
const int LARGE_LEVELS = 28;
const int SMALL_LEVELS = 20;
const int MOST_GENERATIONS = 56;  // 2 + LARGE_LEVELS + 1 of large nodes, SMALL_LEVELS + 1 of small ones; and the end
const int LARGE_PLANES = 15;      // planes across each axis at which a large node may be split, evenly spread
const int LANE_TEXELS = 17;      // notes of a lane about a large node: 2 + 2 LARGE_PLANES
const int MASK_BITS = 64;        // the largest small node   [Zhou 2008, section 3.1]
const float C_TS = 2.0;          // cost of a step in triangle tests
const float EMPTY_SHARE = 0.15;  // C_e: the share of a large node's extent above which empty space is cut off
const float GROWTH_LIMIT = 1.6;  // the most by which a split may multiply the triangles of a large node

// The bounding volume hierarchy.
const int BVH_STACK = 64;        // 30 bits of Morton code and 32 of the triangle's place cannot make a deeper tree
const int BVH_LEAF = 4;          // the most triangles of a leaf
const int SORT_BITS = 6;         // of a digit of the radix sort
const int SORT_CHUNK = 256;      // keys that one invocation sorts in order
