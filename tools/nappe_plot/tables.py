"""Reads a table as nappe writes it: a header line, then numbers with commas between them."""

import csv

import numpy as np


def read(path):
    """Columns as arrays by name, or None if there is no such file or no row in it yet."""
    if not path.exists():
        return None
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    if len(rows) < 2:
        return None
    complete = [row for row in rows[1:] if len(row) == len(rows[0])]  # a run under way may be writing the last one
    numbers = np.array([[float(value) if value else np.nan for value in row] for row in complete])
    return {name.strip(): numbers[:, column] for column, name in enumerate(rows[0])}
