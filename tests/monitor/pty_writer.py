"""A program of its own at the far end of a pseudo-terminal: writes a file into it, piece by piece.

python pty_writer.py FILE PIECE_BYTES PAUSE_S      tells the terminal's name, then waits for a line on stdin
"""

import os
import pty
import sys
import time
import tty

path, size, pause = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
master, slave = pty.openpty()
tty.setraw(slave)
print(os.ttyname(slave), flush=True)
sys.stdin.readline()
with open(path, "rb") as file:
    while piece := file.read(size):
        while piece:
            piece = piece[os.write(master, piece) :]
        time.sleep(pause)
print("written", flush=True)
sys.stdin.readline()
