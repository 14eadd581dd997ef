"""One writer a file format. Each takes blocks and epochs as they come and keeps nothing that grows."""
