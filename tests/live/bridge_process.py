"""An emulated Bus Pirate with a chip at a port of its own process, until its input ends.

python tests/live/bridge_process.py /tmp/ttyBRIDGE [bmi160|adxl345]
"""

import sys
from contextlib import suppress
from pathlib import Path

from bridged_chips import Desktop

if __name__ == "__main__":
    with suppress(KeyboardInterrupt), Desktop(Path(sys.argv[1]), *sys.argv[2:]) as desk:
        print(desk.url, flush=True)
        sys.stdin.read()
