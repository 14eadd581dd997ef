"""Import: recordings of other programs become captures, and what is wrong with them is told."""
