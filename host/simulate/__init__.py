"""The sensor simulator as a tool of its own: what a vehicle's sensors feel, streamed into files."""
