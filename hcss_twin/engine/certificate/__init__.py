"""The certificate: pixels computed again on the reference path."""
