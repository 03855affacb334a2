"""Speed on this machine, as ratios to limits that are measured in the same run."""
