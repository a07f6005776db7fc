"""Page of a cube: frames to step through, curves, geometry of the scene, certificate, provenance."""
