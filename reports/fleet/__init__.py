"""The fleet report: one page (HTML, PDF) about all drives of a store, made of its tables alone."""
