"""A folder of logs: finding the drives in it, doing what is not done yet, and keeping the results."""
