"""The report's templates and style sheet: data, no code."""
