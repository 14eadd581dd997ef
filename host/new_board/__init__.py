"""`navtwin new board`: a working board outside this repository, from templates."""
