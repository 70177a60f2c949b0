"""Method direct: quadrature per pixel at shared nodes."""
