"""Engines: one `map` over tasks, on this machine or many. They know nothing of drives."""
