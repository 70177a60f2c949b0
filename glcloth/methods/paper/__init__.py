"""Method paper: paper A as printed, its tables and their making."""
