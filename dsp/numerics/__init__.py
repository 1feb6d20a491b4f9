"""Numbers that several rooms share: Legendre polynomials, random numbers, checks."""
