"""Tables of the attitude computer beside those of its document: angles, drift, coning, cycles."""
