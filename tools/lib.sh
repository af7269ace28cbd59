# What the tools share; they source it. Sets `root`, the top of the repository.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { echo "${tool:-nappe}: $*" >&2; }

die() {
  say "$*"
  exit 1
}

# configure_and_build PRESET [TARGET…]: in build/PRESET, whatever the working directory; its path goes to $build.
configure_and_build() {
  local preset=$1
  shift
  build=$root/build/$preset
  say "building in $build"
  local said
  said=$(cd "$root" && cmake --preset "$preset" 2>&1) || {
    echo "$said" >&2
    die "cmake could not configure; its message is above"
  }
  cmake --build "$build" --parallel "$(nproc)" ${1:+--target "$@"} >&2
}

# A Python that sees h5py and matplotlib: Debian's, not necessarily the first on PATH.
find_python() {
  local python
  for python in "${NAPPE_PYTHON:-}" /usr/bin/python3 python3; do
    if [ -n "$python" ] && "$python" -c 'import h5py, matplotlib, numpy' >/dev/null 2>&1; then
      echo "$python"
      return
    fi
  done
  die "no Python here imports h5py, numpy and matplotlib: run tools/setup looking, or name one in NAPPE_PYTHON"
}
