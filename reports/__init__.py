"""Tables, figures, HTML and PDF from stored results."""
