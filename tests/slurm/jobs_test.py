"""jobs/*.sbatch and jobs/lib.sh without Slurm: stand-ins for its commands and for nappe, which keep a diary. What has to
be passed on, when a job goes back into the queue and when it must not. The real thing: slurm_test.py."""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = sorted(path.name for path in (ROOT / "jobs").glob("*.sbatch"))
LIMIT = 60  # s; a start takes a tenth of one on an idle machine

# Told by variables: CHECK_CODE, CHECK_SECONDS; WAITS, whether it goes on until USR1 comes; STEP of the checkpoint to
# leave, whose name is new each time; CODE.
NAPPE = """#!/usr/bin/env bash
echo "nappe $*" >>"$DIARY"
case $1 in
  check) sleep "${CHECK_SECONDS:-0}"; exit "${CHECK_CODE:-0}" ;;
  run) while [ "$1" != --out ]; do shift; done; folder=$2 ;;
  restart) folder=$2 ;;
esac
mkdir -p "$folder/checkpoints"
n=0
trap 'n=$((n + 1)); echo "nappe got USR1" >>"$DIARY"' USR1
trap 'echo "nappe got TERM" >>"$DIARY"; n=1' TERM
touch "$folder/begun"
if [ -n "${WAITS:-}" ]; then
  while [ "$n" = 0 ]; do sleep 0.05; done
  sleep 0.5 # writes its checkpoint; a second signal would be seen here
fi
if [ -n "${STEP:-}" ]; then
  printf '    "serial": %s,\\n    "stage": "push",\\n    "step": %s\\n' $$ "$STEP" >"$folder/checkpoints/$$.json"
fi
exit "${CODE:-0}"
"""
SQUEUE = """#!/usr/bin/env bash
echo "${LEFT-20:00}"
"""
SCONTROL = """#!/usr/bin/env bash
echo "scontrol $*" >>"$DIARY"
exit "${SCONTROL_CODE:-0}"
"""


class Start:
    """One start of a batch script, as slurmd makes it."""

    def __init__(self, test, script, *arguments, **variables):
        self.test = test
        diary = test.folder / "diary"
        diary.unlink(missing_ok=True)
        environment = dict(
            os.environ,
            PATH=f"{test.folder}/bin:{os.environ['PATH']}",
            DIARY=str(diary),
            NAPPE=str(test.folder / "bin/nappe"),
            MPIRUN="env",
            OUT=str(test.out),
            SLURM_SUBMIT_DIR=str(ROOT),
            SLURM_JOB_ID="77",
            **{name: str(value) for name, value in variables.items()},
        )
        self.process = subprocess.Popen(
            ["bash", ROOT / "jobs" / script, *arguments],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def signal(self, number, once="begun"):
        """As soon as nappe has left that file in its folder, or is in the diary with that word."""
        deadline = time.monotonic() + LIMIT
        diary = self.test.folder / "diary"
        while not ((self.test.out / once).exists() or (diary.exists() and once in diary.read_text())):
            if time.monotonic() > deadline:
                raise AssertionError(f"{once} did not come about")
            time.sleep(0.02)
        self.process.send_signal(number)
        return self

    def end(self, code):
        try:
            self.printed, _ = self.process.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            raise AssertionError(f"still running after {LIMIT} s") from None
        self.test.assertEqual(self.process.returncode, code, self.printed)
        diary = self.test.folder / "diary"
        self.diary = diary.read_text().splitlines() if diary.exists() else []
        return self

    @property
    def requeued(self):
        return "scontrol requeue 77" in self.diary


class Jobs(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nappe-jobs-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = self.folder / "out"
        (self.folder / "bin").mkdir()
        for name, text in (("nappe", NAPPE), ("squeue", SQUEUE), ("scontrol", SCONTROL)):
            path = self.folder / "bin" / name
            path.write_text(text)
            path.chmod(0o755)

    def start(self, *arguments, script="fold-small.sbatch", **variables):
        return Start(self, script, *arguments, **variables)

    def leave_checkpoint(self):
        (self.out / "checkpoints").mkdir(parents=True, exist_ok=True)
        (self.out / "checkpoints/checkpoint-000007.json").touch()

    def test_first_start_checks_and_runs_with_all_arguments(self):
        arguments = ["--set", "solver.h=0.01", "--steps", "40", "--set=laws.0.friction=0.3", "--samples", "s"]
        diary = self.start(*arguments).end(0).diary
        self.assertEqual(diary[0], "nappe check jobs/fold-small.toml --set solver.h=0.01 --set=laws.0.friction=0.3")
        run = f"nappe run jobs/fold-small.toml --out {self.out} {' '.join(arguments)} --wall-time 00:19:30"
        self.assertEqual(diary[1:], [run])

    def test_where_checkpoints_are_it_goes_on_with_the_same_arguments(self):
        self.leave_checkpoint()
        arguments = ["--set", "solver.sweeps=50", "--steps=40", "--checkpoint-every", "500,1min"]
        restart = f"nappe restart {self.out} {' '.join(arguments)} --wall-time 00:19:30"
        for restarts in (0, 1):  # of a new job for the same folder, and of one that was requeued
            self.assertEqual(self.start(*arguments, SLURM_RESTART_COUNT=restarts).end(0).diary, [restart])

    def test_wall_time_is_what_is_left_less_a_margin(self):
        for left, wanted in (
            ("1-02:03:04", "--wall-time 26:02:34"),
            ("08:09:09", "--wall-time 08:08:39"),
            ("1:00", "--wall-time 00:00:30"),
            ("0:20", ""),
            ("UNLIMITED", ""),
            ("INVALID", ""),
            ("", ""),
        ):
            run = self.start(LEFT=left).end(0).diary[-1]
            self.assertEqual(run.partition(str(self.out))[2].strip(), wanted, left)
        for mine in (["--wall-time", "00:00:07"], ["--wall-time=00:00:07"]):
            run = self.start(*mine).end(0).diary[-1]
            self.assertTrue(run.endswith(" ".join(mine)) and run.count("--wall-time") == 1, run)
        self.assertIn("00:18:20", self.start(WALL_MARGIN=100).end(0).diary[-1])

    def test_an_unsound_scene_ends_with_its_code_before_any_run(self):
        diary = self.start(CHECK_CODE=2).end(2).diary
        self.assertEqual(len(diary), 1, diary)

    def test_usr1_is_passed_on_once_and_the_job_goes_back_into_the_queue(self):
        start = self.start(WAITS=1, STEP=10, CODE=3).signal(signal.SIGUSR1)
        start.signal(signal.SIGUSR1, once="nappe got USR1").end(3)
        self.assertEqual(start.diary.count("nappe got USR1"), 1)
        self.assertTrue(start.requeued, start.printed)

    def test_usr2_ends_it_at_a_checkpoint_and_does_not_go_on(self):
        start = self.start(WAITS=1, STEP=10, CODE=3).signal(signal.SIGUSR2).end(3)
        self.assertIn("nappe got USR1", start.diary)
        self.assertFalse(start.requeued)

    def test_term_waits_for_the_end_and_leaves_the_rest_to_slurm(self):
        start = self.start(WAITS=1, STEP=10, CODE=3).signal(signal.SIGTERM)
        time.sleep(0.5)
        self.assertIsNone(start.process.poll())
        children = subprocess.run(
            ["pgrep", "-P", str(start.process.pid)], stdout=subprocess.PIPE, text=True, check=True
        ).stdout.split()
        os.kill(int(children[0]), signal.SIGTERM)  # Slurm tells every process of the job
        start.end(3)
        self.assertFalse(start.requeued)
        self.assertIn("Slurm ends it", start.printed)

    def test_a_signal_before_the_run_begins_it_not(self):
        start = self.start(CHECK_SECONDS=1).signal(signal.SIGUSR1, once="nappe check").end(3)
        self.assertEqual([line.split()[:2] for line in start.diary], [["nappe", "check"]])
        self.assertFalse(start.requeued)

    def test_it_goes_on_only_from_a_further_checkpoint(self):
        for code, first, second in ((3, 10, 20), (137, 30, 40)):
            self.assertFalse(self.start(CODE=code).end(code).requeued)
            self.assertTrue(self.start(CODE=code, STEP=first).end(code).requeued)
            again = self.start(CODE=code, STEP=first, SLURM_RESTART_COUNT=1).end(code)
            self.assertFalse(again.requeued)
            self.assertIn("no checkpoint that is further on", again.printed)
            self.assertTrue(self.start(CODE=code, STEP=second, SLURM_RESTART_COUNT=2).end(code).requeued)

    def test_other_codes_are_the_end(self):
        for code in (0, 1, 2, 4):
            self.assertFalse(self.start(CODE=code, STEP=10 + code).end(code).requeued)

    def test_the_number_of_starts_is_bounded(self):
        self.assertTrue(self.start(CODE=3, STEP=10, MAX_RESTARTS=2, SLURM_RESTART_COUNT=1).end(3).requeued)
        self.assertFalse(self.start(CODE=3, STEP=20, MAX_RESTARTS=2, SLURM_RESTART_COUNT=2).end(3).requeued)
        over = self.start(CODE=3, STEP=30, MAX_RESTARTS=2, SLURM_RESTART_COUNT=3).end(3)
        self.assertEqual(over.diary, [], "Slurm itself may start a job again and again")

    def test_a_queue_that_does_not_take_it_back_is_said(self):
        start = self.start(CODE=3, STEP=10, SCONTROL_CODE=1).end(3)
        self.assertIn("scontrol requeue failed", start.printed)

    def test_a_finished_run_is_left_alone(self):
        self.out.mkdir()
        (self.out / "summary.json").write_text('{\n  "stopped_early": false,\n  "steps": 9\n}\n')
        self.assertEqual(self.start(SLURM_RESTART_COUNT=1).end(0).diary, [])
        self.leave_checkpoint()  # nappe restart knows what is left of it
        self.assertIn("nappe restart", self.start(SLURM_RESTART_COUNT=1).end(0).diary[0])

    def test_the_sweep_names_a_folder_and_a_cohesion_for_each_index(self):
        array = {"script": "fault-sweep.sbatch", "SLURM_ARRAY_JOB_ID": 70}
        for index, scene, gamma in ((0, "fault", "0"), (3, "fault", "1e5"), (6, "fault-large", "1e4")):
            check, run = self.start("--steps", "9", SLURM_ARRAY_TASK_ID=index, **array).end(0).diary
            self.assertEqual(check, f"nappe check jobs/{scene}.toml --set materials.rock.gamma={gamma}")
            self.assertIn(f"--out {self.out}-{scene}-gamma{gamma} --set materials.rock.gamma={gamma} --steps 9", run)
        self.start(SLURM_ARRAY_TASK_ID=8, **array).end(2)

    def test_the_study_stops_its_runs_and_goes_back_into_the_queue(self):
        array = {"script": "fault-study.sbatch", "SLURM_ARRAY_TASK_ID": 1, "SLURM_CPUS_PER_TASK": 2}
        start = self.start("--quick", **array, WAITS=1, STEP=10, CODE=3)
        start.signal(signal.SIGUSR1, once="theta45-h3-gamma0-seed1/begun").end(3)
        self.assertEqual([line.split()[1] for line in start.diary if line.startswith("nappe ")][0], "run")
        self.assertIn("nappe got TERM", start.diary)
        self.assertTrue(start.requeued, start.printed)

    def test_all_scripts_ask_slurm_for_the_same(self):
        self.assertEqual(len(SCRIPTS), 4)
        for name in SCRIPTS:
            text = (ROOT / "jobs" / name).read_text()
            for line in ("--requeue", "--open-mode=append"):
                self.assertIn(f"\n#SBATCH {line}\n", text, name)
            self.assertRegex(text, r"\n#SBATCH --signal=B:USR1@\d+\n")
            self.assertEqual(len(re.findall(r"^\. jobs/lib\.sh$", text, re.MULTILINE)), 1, name)
            self.assertNotRegex(text, r"(?m)^(trap|exec|mpirun)")
            self.assertEqual(subprocess.run(["bash", "-n", ROOT / "jobs" / name]).returncode, 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]], verbosity=2)
