"""One run of a board: request in, board and world built, virtual time worked off, result out."""

import gc

SELDOM = 50_000
"""New objects after which the collector of cycles looks at them. Libraries and kernels, when they are loaded,
make a million that stay and hardly any cycles: 0.1 s of looking at the usual 700."""

gc.set_threshold(SELDOM)
