"""One run of a board: request in, board and world built, virtual time worked off, result out."""
