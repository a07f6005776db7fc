"""Page of a posterior: corner plot, traces, convergence, priors, prediction."""
