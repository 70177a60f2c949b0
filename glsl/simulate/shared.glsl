// What the simulation's passes and glcloth/simulation/cloth.py share; read by glcloth/gpu/layout.py.

const int MAX_NEAR = 64;     // candidates for contact that one vertex can hold
