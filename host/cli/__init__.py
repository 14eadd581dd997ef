"""The command `navtwin`."""
