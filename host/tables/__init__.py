"""Tables of the attitude computer beside its document's: positions of a rotary table, drift, coning, cycles."""
