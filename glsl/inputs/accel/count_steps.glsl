// Counts the steps through a tree and the triangle tests of each ray, for measurements.
layout(std430) writeonly buffer Work { uvec2 work[]; };
uint steps_done = 0u;
uint tests_done = 0u;
void count_step() { steps_done += 1u; }
void count_test() { tests_done += 1u; }
void count_store(int i) { work[i] = uvec2(steps_done, tests_done); }
