"""Many pictures by many processes, on this machine or on others."""
