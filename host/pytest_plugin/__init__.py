"""What the fixture `navtwin_run` does; pytest itself loads `navtwin_pytest` only."""
