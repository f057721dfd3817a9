"""The marginalised particle filter of Berntorp, Chakrabarty and Di Cairano: roll stiffness, damping and CG height."""
