"""Roll plane and pitch plane from strut forces (gPC dissertation, 6.1-6.2), as published and over the whole drive."""
