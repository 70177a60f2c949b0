// The number of an invocation, or of a work group, in a dispatch along one line. A device takes only so many work groups
// along x (65,535 on many); beyond that glcloth/gpu/programs.py lays them in rows.
// Include it after the layout of the work group.
int item() { return int(gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x); }
int group() { return int(gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x); }
