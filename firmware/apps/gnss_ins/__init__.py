"""What the programs of all boards with a receiver and an inertial sensor share: output, words, dating."""
