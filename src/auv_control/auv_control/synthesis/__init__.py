"""How the numbers of a control law are found, before any flight."""
