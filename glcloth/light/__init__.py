"""An environment map becomes lights: spherical Gaussians and suns."""
