"""The simulator's figures beside those of its document, each measured anew: `navtwin proof`."""
