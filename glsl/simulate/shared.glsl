// Constants that the simulation's passes and glcloth/simulation/cloth.py share; glcloth/gpu/layout.py reads them.

const int MAX_NEAR = 64;     // candidates for contact that one vertex can hold
