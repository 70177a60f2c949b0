"""Picture files of scene light: OpenEXR and Radiance."""
