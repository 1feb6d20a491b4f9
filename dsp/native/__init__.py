"""How kernels are compiled, and what they need of the machine. It knows no sound."""
