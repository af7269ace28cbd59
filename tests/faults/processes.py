"""Processes of a job: which there are, and what may be left of it."""

import os
import pathlib


def children(pid):
    """Process ids of all that descend from one, as far as they are alive."""
    parents = {}
    for folder in pathlib.Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                fields = (folder / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue  # gone meanwhile
            if fields[0] != "Z":
                parents.setdefault(int(fields[1]), []).append(int(folder.name))
    found, todo = [], [pid]
    while todo:
        for child in parents.get(todo.pop(), []):
            found.append(child)
            todo.append(child)
    return found


def ranks_of(pid, program):
    """Those of its descendants that run the program."""
    found = []
    for child in children(pid):
        try:
            if os.readlink(f"/proc/{child}/exe") == os.path.realpath(program):
                found.append(child)
        except OSError:
            pass
    return found


def alive(pids):
    """Those of them that still run."""
    found = []
    for pid in pids:
        try:
            state = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            continue
        if state != "Z":
            found.append(pid)
    return found
