# What the batch scripts share; they source it from the root of the repository. jobs/README.md tells users what it does:
# a job that nears its time limit stops at a checkpoint, puts itself back into the queue and goes on from there.
#
#   nappe_job SCENE DIR [ARGUMENTS…]   nappe run, or nappe restart where DIR holds checkpoints; ends the script
#   begin_job DIR…                     of other programs: before watch_over; DIR… hold the checkpoints to be
#   watch_over COMMAND…                runs it and passes USR1 on to it; its exit code goes to $code
#   end_job                            puts the job back into the queue if it is to go on; ends the script
nappe=${NAPPE:-build/cluster/nappe}
# mpirun of an Open MPI built with Slurm support takes nodes and ranks from the allocation. Where the cluster's srun starts
# MPI programs itself (srun --mpi=list names pmix): MPIRUN="srun --mpi=pmix --cpu-bind=cores"
read -ra launcher <<<"${MPIRUN:-mpirun -q --bind-to core --map-by core}"
max_restarts=${MAX_RESTARTS:-50}
wall_margin=${WALL_MARGIN:-30} # s before the time limit at which nappe stops by its own clock if no signal came

restarts=${SLURM_RESTART_COUNT:-0}
folders=()
before=
child=
code=0
stopping= # why, once a signal has come
signals=0

say() { echo "[$(date +%T)] job ${SLURM_JOB_ID:?submit this file with sbatch}, start $((restarts + 1)): $*"; }

# USR1: out of time. USR2: the user's wish to end it here. Only the first is passed on: a second one would end nappe at
# once, without its checkpoint.
stop_child() {
  trap '' USR1 USR2
  signals=$((signals + 1))
  stopping=$1
  if [ -n "$child" ]; then kill -USR1 "$child" 2>/dev/null || true; fi
}
trap 'stop_child limit' USR1
trap 'stop_child wish' USR2
# Slurm ends the job (scancel, preemption, a requeue from outside) and has told mpirun itself. Bash only waits for it: if
# this script ended, Slurm would kill the rest at once.
trap 'stopping=slurm; signals=$((signals + 1))' TERM

is_finished() { grep -Eqs '"stopped_early": *false' "$1/summary.json"; }
has_checkpoints() { [ -n "$(find "$1/checkpoints" -name '*.json' 2>/dev/null)" ]; }

# A line for every place that a start could go on from, or that is the end: stage and step of each checkpoint.
results() {
  local folder file
  for folder in "${folders[@]}"; do
    if is_finished "$folder"; then echo "$folder finished"; fi
    for file in "$folder"/checkpoints/*.json; do
      if [ -e "$file" ]; then echo "$folder $(grep -E '"(stage|step)":' "$file" | tr -d ' \n')"; fi
    done
  done | sort -u
}

begin_job() {
  folders=("$@")
  before=$(results)
  if [ "$restarts" -gt "$max_restarts" ]; then
    say "has been started more often than MAX_RESTARTS=$max_restarts allows; ${folders[*]} holds what there is"
    exit 3
  fi
}

watch_over() {
  if [ -n "$stopping" ]; then # before it began
    code=3
    return
  fi
  "$@" &
  child=$!
  if [ -n "$stopping" ]; then kill -USR1 "$child" 2>/dev/null || true; fi
  # A wait that a signal cuts short has not waited: wait again, to end as the command ends.
  local known
  while :; do
    known=$signals
    code=0
    wait "$child" || code=$?
    if [ "$known" = "$signals" ]; then break; fi
  done
  child=
}

# Exit code 3: stopped early, by the signal or by its clock. Beyond 128: a process was killed, by whom nobody knows, be it
# for a node's lack of memory. What ended otherwise would end the same way again.
end_job() {
  local no=
  if [ "$code" = 0 ] || { [ "$stopping" != slurm ] && [ "$code" != 3 ] && [ "$code" -le 128 ]; }; then
    say "ended with exit code $code (0 done, 2 bad input, 3 stopped early, 4 numerical failure); results in ${folders[*]}"
    exit "$code"
  elif [ "$stopping" = slurm ]; then
    no="Slurm ends it, and starts it again itself if it is to go on"
  elif [ "$stopping" = wish ]; then
    no="USR2 asked for that"
  elif [ -z "$(comm -13 <(echo "$before") <(results))" ]; then
    no="this start has left no checkpoint that is further on, and the next would not either: give it more time"
  elif [ "$restarts" -ge "$max_restarts" ]; then
    no="MAX_RESTARTS=$max_restarts"
  elif say "ended with exit code $code; back into the queue" && ! scontrol requeue "$SLURM_JOB_ID"; then
    no="scontrol requeue failed"
  fi
  if [ -n "$no" ]; then say "ended with exit code $code and does not go on: $no; results in ${folders[*]}"; fi
  exit "$code"
}

# Time left of the job less the margin, as --wall-time takes it; nothing if the job has no limit.
wall_time() {
  local left
  left=$(squeue -h -j "$SLURM_JOB_ID" -o %L 2>/dev/null) || return 0
  if ! [[ $left =~ ^(([0-9]+)-)?(([0-9]+):)?([0-9]+):([0-9]+)$ ]]; then return 0; fi
  local days=${BASH_REMATCH[2]:-0} hours=${BASH_REMATCH[4]:-0} minutes=${BASH_REMATCH[5]} seconds=${BASH_REMATCH[6]}
  seconds=$((((10#$days * 24 + 10#$hours) * 60 + 10#$minutes) * 60 + 10#$seconds - wall_margin))
  if [ "$seconds" -gt 0 ]; then
    printf '%02d:%02d:%02d' $((seconds / 3600)) $((seconds / 60 % 60)) $((seconds % 60))
  fi
}

# pick OPTION… -- ARGUMENTS…: of the arguments those options with their values, into $picked.
pick() {
  local options=" "
  while [ "$1" != -- ]; do
    options+="$1 "
    shift
  done
  shift
  picked=()
  while [ $# -gt 0 ]; do
    if [[ $options == *" ${1%%=*} "* ]]; then
      picked+=("$1")
      if [[ $1 != *=* ]] && [ $# -gt 1 ]; then
        picked+=("$2")
        shift
      fi
    fi
    shift
  done
}

nappe_job() {
  local scene=$1 out=$2
  shift 2
  begin_job "$out"
  local limit=() wall
  pick --wall-time -- "$@"
  if [ ${#picked[@]} = 0 ]; then
    wall=$(wall_time)
    limit=(${wall:+--wall-time "$wall"})
  fi
  if has_checkpoints "$out"; then
    # The keys of the scene are those in the folder already; set again to the same values they change nothing.
    say "goes on with $out"
    watch_over "${launcher[@]}" "$nappe" restart "$out" "$@" "${limit[@]}"
  elif is_finished "$out"; then
    say "$out is finished already: nothing to do"
    exit 0
  else
    # Write down what runs, and stop here if the scene is not sound: one process, no waiting ranks.
    pick --set -- "$@"
    "$nappe" check "$scene" "${picked[@]}"
    mkdir -p "$(dirname "$out")"
    # What a start of this very job left before its first checkpoint can not be gone on from.
    local anew=()
    if [ "$restarts" -gt 0 ]; then anew=(--overwrite); fi
    watch_over "${launcher[@]}" "$nappe" run "$scene" --out "$out" "${anew[@]}" "$@" "${limit[@]}"
  fi
  end_job
}
