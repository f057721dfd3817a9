"""The gPC dissertation's regression filter on its simple roll-plane model (3.6-3.9)."""
