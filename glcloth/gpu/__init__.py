"""The ground on OpenGL: context, programs, buffers, the G-buffer."""
