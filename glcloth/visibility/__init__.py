"""How far a surface sees the lights, and the light that other surfaces send back to it."""
