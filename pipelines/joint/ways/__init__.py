"""Other posteriors that a drive may speak for: what no spread of an unknown reaches, each with a fit and odds of its own."""
