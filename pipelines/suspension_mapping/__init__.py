"""Suspension mapping: tyre normal forces from what the suspension feels, trained on a drive with measuring wheels."""
