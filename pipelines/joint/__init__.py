"""One joint posterior over the vehicle from every relation that a drive supports."""
