//! From the points of a centerline to a curve: regression on Bernstein polynomials.
