"""The live view: what a board says, shown in a terminal while it says it.

state, track, link_health      what is known of the board, of bounded size
view                           the same as a picture for `rich` (`MonitorView`), which others embed
figures                        the same as one JSON object
"""
