"""The page *Operate*, followed literally: every shell command that it shows is run."""
