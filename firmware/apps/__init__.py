"""Programs: one package per board, one program per processor."""
