"""Roll dynamics by batch maximum a posteriori, on the model of Berntorp et al."""
