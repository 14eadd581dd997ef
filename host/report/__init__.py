"""What people read after a run: tables for the terminal and a self-contained HTML page."""
