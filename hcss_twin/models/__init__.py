"""Providers that ship with the package; they stand behind the provider contract like those of third parties."""
