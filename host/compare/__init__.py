"""The same board's computations in several arithmetics, side by side on one stream of words from the bus."""
