"""Stages of the frames of a scene, from clouds to derived variables."""
