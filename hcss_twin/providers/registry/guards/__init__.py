"""Wrappers that check the results of providers, by kind."""
