"""Monte Carlo radiance of clouds in three dimensions: the reference for approximations that are faster."""
