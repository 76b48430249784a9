//! From an image to the ordered centerlines of the ropes in it.
