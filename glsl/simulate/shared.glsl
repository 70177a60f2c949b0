// What the simulation's passes and glcloth/simulation.py share; read by glcloth/layout.py.

const int MAX_NEAR = 64;     // candidates for contact that one vertex can hold
