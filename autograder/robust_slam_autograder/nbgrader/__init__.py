"""nbgrader's side: settings, gradebook, formgrader, and its own commands on our executor."""
