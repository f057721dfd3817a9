"""What if something that was taken for known is otherwise? Doubts: another prior of a few unknowns, with a chance of its own."""
