"""How uncertain radiance is because cloud parameters and other inputs of a scenario are."""
