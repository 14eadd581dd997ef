"""What a run that was killed had not decoded yet, decoded anew from the raw traffic in its capture."""
