// The rays that a pass casts, as the CPU says.
uniform int ray_count;
uniform int first_ray;
