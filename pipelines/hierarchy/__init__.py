"""What a fleet's drives say together: per vehicle what is shared and what is each drive's load; changes, trends, outliers."""
