"""Real hardware beside the twin: a board that is shown, recorded and shadowed; a receiver in place of the
emulated one."""
