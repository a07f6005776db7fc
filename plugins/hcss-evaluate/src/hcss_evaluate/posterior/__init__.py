"""``hcss fit``: posteriors of cloud parameters given images, by Markov chain Monte Carlo."""
