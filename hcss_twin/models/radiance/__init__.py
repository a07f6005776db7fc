"""Assembly of radiance terms (eqs 15-20), and the reference path."""
