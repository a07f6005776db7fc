"""Page of a propagation: how radiance scatters over draws, and which input it scatters by."""
