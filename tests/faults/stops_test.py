"""How a run is stopped: signals to a rank or to mpirun, wall time."""

import os
import signal
import time

from processes import alive, children, ranks_of
from run_kit import BAD_INPUT, DONE, MOST, OTHER, STOPPED, FaultTest, call, paths, sets

from nappe_driver import Run, finish, main


class Signals(FaultTest):
    def stopped(self, process, send):
        self.wait(process, lambda: self.rows() > 3)
        send(process)
        result = finish(process)
        self.assertEqual(result.code, STOPPED, str(result))
        self.assertEqual(result.err.count("stopped; go on with nappe restart"), 1, result.err)
        summary_steps = self.whole.summary["steps"]
        self.assertLess(self.last_step(), summary_steps)
        self.assert_goes_on()

    def test_any_signal_to_one_rank_stops_all(self):
        for number in (signal.SIGUSR1, signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            with self.subTest(signal=number.name):
                self.fresh()

                def to_last_rank(process, number=number):
                    os.kill(ranks_of(process.pid, paths.nappe)[-1], number)

                self.stopped(self.start(ranks=3), to_last_rank)

    def test_usr1_and_usr2_to_mpirun(self):
        for number in (signal.SIGUSR1, signal.SIGUSR2):
            with self.subTest(signal=number.name):
                self.fresh()
                self.stopped(self.start(), lambda process, number=number: process.send_signal(number))

    def test_term_to_mpirun_leaves_something_to_go_on_from(self):
        process = self.start("--checkpoint-every", "5")
        self.wait(process, self.checkpoints)
        process.send_signal(signal.SIGTERM)
        result = finish(process)
        self.assertNotEqual(result.code, DONE)
        self.assert_goes_on()

    def test_a_second_signal_ends_it_at_once(self):
        # Steps of so many sweeps that the first signal is not heard for a long time.
        process = self.start(*sets(stages__push__solver__sweeps=3000000))
        self.wait(process, lambda: self.rows() > 0)
        time.sleep(0.3)
        family = children(process.pid)
        process.send_signal(signal.SIGUSR1)
        time.sleep(0.2)
        process.send_signal(signal.SIGUSR1)  # the same one by two ways does not count
        time.sleep(1.5)
        self.assertIsNone(process.poll(), "the first signal ended a step: the case is none")
        process.send_signal(signal.SIGUSR1)
        result = finish(process, MOST)
        self.assertNotIn(result.code, (DONE, STOPPED))
        self.assertEqual(alive(family), [])


class WallTime(FaultTest):
    def test_it_ends_before_and_goes_on(self):
        begun = time.monotonic()
        result = self.run_it("--wall-time", "00:00:02", *sets(stages__push__duration=2000), code=STOPPED)
        self.assertIn("go on with nappe restart", result.err)
        # From mpirun's start to its end; one step and one checkpoint over, on a machine that does other things too.
        self.assertLess(time.monotonic() - begun, 2 + MOST)
        self.assertEqual(self.restart("--steps", self.last_step() + 5).summary["restarts"], 1)

    def test_without_checkpoints_it_is_not_restartable(self):
        process = self.start("--wall-time", "00:00:01", "--checkpoint-every", "never", *sets(stages__push__duration=2000))
        result = finish(process)
        self.assertEqual(result.code, OTHER, str(result))
        self.assertIn("there is no checkpoint to go on from", result.err)
        self.assertFalse(Run(self.out, result).summary["restartable"])

    def test_what_it_must_look_like(self):
        for text in ("2", "00:01", "00:00:00", "-1:00:00", "00:61:00", "1h"):
            with self.subTest(text=text):
                result = self.run_it("--wall-time", text, ranks=0, code=BAD_INPUT)
                self.assertIn(f'--wall-time: must be HH:MM:SS, more than nothing, found "{text}"', result.err)
        for text in ("0", "-3", "1.5", "10 min", "3,4", "10min,2h", "always", "500,"):
            with self.subTest(text=text):
                result = self.run_it("--checkpoint-every", text, ranks=0, code=BAD_INPUT)
                self.assertIn(f'found "{text}"', result.err)
        self.assertFalse(self.out.exists())

    def test_help_names_them(self):
        for command in ("run", "restart"):
            text = call([command, "--help"]).out
            for option in ("--checkpoint-every", "--wall-time", "--steps", "--set"):
                self.assertIn(option, text)


if __name__ == "__main__":
    main()
