"""How uncertain cloud parameters are, given images: posteriors by Markov chain Monte Carlo."""
