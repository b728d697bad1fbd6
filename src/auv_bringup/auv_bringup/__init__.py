"""Composition: scenarios, in-process runner, launcher, recorder, replay, metrics, figures and report."""
