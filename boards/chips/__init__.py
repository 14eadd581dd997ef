"""Register-level models of the chips on the boards.

A chip model has two faces. The bus face speaks registers as the part's fact sheet gives them; the world
face (`boards.chips.world`) asks for physical quantities at the chip's own sample instants. A model never
shares code, constants or decoding with the firmware's driver for the part.
"""
