"""The integrated observer of Park & Choi, as published."""
