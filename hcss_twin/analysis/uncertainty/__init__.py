"""Uncertainty of cloud parameters given images: posteriors by Markov chain Monte Carlo."""
