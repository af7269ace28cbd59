"""Folders build on each other one way only: core <- parallel <- solver <- commands, main; core, parallel <- io. And MPI
is named in src/parallel alone (src/io hands a communicator to HDF5). Usage: layers_test.py SOURCE_FOLDER"""

import pathlib
import re
import sys
import tempfile
import unittest

MAY_INCLUDE = {
    "core": {"core"},
    "parallel": {"core", "parallel"},
    "io": {"core", "parallel", "io"},
    "solver": {"core", "parallel", "solver"},
    "commands": {"core", "parallel", "io", "solver", "commands"},
    "main.cpp": {"core", "parallel", "io", "solver", "commands"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
MPI_NAME = re.compile(r"\bP?MPI_[A-Za-z_]+")
MPI_OF_IO = {"MPI_INFO_NULL"}  # H5Pset_fapl_mpio wants it
SOURCES = {".cpp", ".hpp", ".inl", ".h"}


def code_of(line):
    """The line without its comment, as far as comments here are of one kind."""
    return line.split("//")[0]


def breaches(folder):
    """Every line that breaks a rule, as FILE:LINE: what."""
    found = []
    for path in sorted(p for p in folder.rglob("*") if p.suffix in SOURCES):
        name = path.relative_to(folder)
        layer = name.parts[0]
        if layer not in MAY_INCLUDE:
            found.append(f"{name}: no layer of this name; give it a place in tests/e2e/layers_test.py")
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            where = f"{name}:{number}"
            include = INCLUDE.match(line)
            if include:
                target = include.group(1)
                other = target.split("/")[0]
                if other in MAY_INCLUDE and other not in MAY_INCLUDE[layer]:
                    found.append(f"{where}: {layer} includes {target}")
                if re.fullmatch(r"p?mpi(cxx)?\.h", target) and layer != "parallel":
                    found.append(f"{where}: <{target}> outside src/parallel")
            allowed = MPI_OF_IO if layer == "io" else set()
            if layer != "parallel":
                found += [f"{where}: {m}" for m in MPI_NAME.findall(code_of(line)) if m not in allowed]
    return found


class Layers(unittest.TestCase):
    folder = None

    def test_sources_keep_to_their_layers(self):
        self.assertGreater(len(list(self.folder.rglob("*.cpp"))), 20, "these are not the sources")
        self.assertEqual(breaches(self.folder), [])

    def test_breaches_are_found(self):
        bad = {
            "core/a.hpp": '#include "parallel/halo.hpp"\n',
            "parallel/b.cpp": '#include "solver/nsgs.hpp"\n#include <mpi.h>\nMPI_Barrier(c);\n',
            "solver/c.cpp": '#include "io/series.hpp"\n',
            "io/d.cpp": "#include <mpi.h>\nuse(MPI_INFO_NULL); MPI_Barrier(c); // MPI_Comm\n",
            "extras/e.cpp": "",
            "main.cpp": '#include "commands/run.hpp"\n',
        }
        with tempfile.TemporaryDirectory() as folder:
            for name, text in bad.items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(exist_ok=True)
                path.write_text(text)
            found = breaches(pathlib.Path(folder))
        files = ["core/a.hpp", "extras/e.cpp", "io/d.cpp", "io/d.cpp", "parallel/b.cpp", "solver/c.cpp"]
        self.assertEqual([f.split(":")[0] for f in found], files)


if __name__ == "__main__":
    Layers.folder = pathlib.Path(sys.argv.pop())
    unittest.main(verbosity=2)
