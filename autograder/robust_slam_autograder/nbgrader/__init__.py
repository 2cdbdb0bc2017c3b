"""nbgrader's side: release, gradebook, formgrader, and its own commands on our executor."""
