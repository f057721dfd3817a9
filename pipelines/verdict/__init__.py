"""One answer a parameter, from all that the estimators say."""
