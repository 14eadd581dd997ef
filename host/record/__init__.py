"""What a run leaves behind: request, result, decoded series, manifest, solution.csv and the run's folder."""
