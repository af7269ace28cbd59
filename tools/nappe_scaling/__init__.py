"""What counts of many ranks' work and messages become in time: docs/scaling.md states the formulas."""
