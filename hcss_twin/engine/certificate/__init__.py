"""The certificate: pixels recomputed on the reference path."""
