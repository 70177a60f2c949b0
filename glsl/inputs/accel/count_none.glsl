// Counts nothing: steps through a tree and triangle tests of a ray.
void count_step() {}
void count_test() {}
void count_store(int i) {}
