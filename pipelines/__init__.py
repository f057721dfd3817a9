"""From a drive's signals to a verdict: preparation, models, filters, estimators, priors."""
