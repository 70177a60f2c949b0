"""What a surface sees of the lights, and what light comes back to it."""
