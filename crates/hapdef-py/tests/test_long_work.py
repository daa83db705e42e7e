"""Live streams, training, and long work that lets others run and can be stopped."""

import _thread
import os
import signal
import threading
import time
import unittest

import numpy as np

import hapdef
from support import OUT, SHIN, THREADS, placed, tensor


class Streams(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = placed()

    def frames(self):
        with self.scene.live(seconds=2.0, tare_s=0.5, seed=1) as live:
            return [(f.seq, f.phase, [(c.force_n, *c.position_m) for c in f.contacts]) for f in live]

    def test_a_play_is_the_same_each_time_and_has_contacts(self):
        frames = self.frames()
        self.assertEqual([seq for seq, _, _ in frames], list(range(2000)))
        self.assertEqual([phase for _, phase, _ in frames[:400]], ["taring"] * 400)
        self.assertTrue(any(contacts for _, _, contacts in frames))
        self.assertEqual(self.frames(), frames)

    def test_frames_say_how_sure_they_are(self):
        phases = set()
        with self.scene.live(seconds=2.0, tare_s=0.5, seed=1) as live:
            for frame in live:
                phases.add(frame.phase)
                self.assertEqual(frame.why_unknown is None, frame.phase != "unknown")
                if frame.phase in ("untouched", "touched") and not frame.is_stale:
                    known = [c.id for c in frame.known_contacts()]
                    self.assertEqual(known, [c.id for c in frame.contacts])
                    self.assertEqual(bool(known), frame.phase == "touched")
                    self.assertTrue(0.0 < frame.smallest_seen_n < 5.0, frame.smallest_seen_n)
                    quality = frame.quality
                    self.assertEqual(quality.why_not is None, quality.is_identified)
                    self.assertTrue(0.0 <= quality.p_value <= 1.0 and quality.n_dof > 0)
                else:
                    self.assertRaises(hapdef.HapdefError, frame.known_contacts)
        self.assertTrue({"taring", "untouched", "touched"} <= phases, phases)

    def test_a_stream_that_is_left_ends(self):
        start = time.monotonic()
        with self.scene.live() as live:
            frame = next(live)
            self.assertEqual(frame.raw_ue.shape, (10,))
            self.assertEqual(live.health()["n_lost"], 0)
        self.assertIsNone(live.health())
        self.assertEqual(list(live), [])
        self.assertLess(time.monotonic() - start, 60.0)


class Training(unittest.TestCase):
    """The bundled scene, whose limb and rig the demo has solved, with few samples and steps."""

    @classmethod
    def setUpClass(cls):
        few = {"steps": 20}
        amounts = {
            "n_single": 400,
            "n_multi": 100,
            "n_real_single": 400,
            "n_pairs": 5,
            "n_amplitudes": 4,
            "transfer": few,
            "reconstruction": few,
            "sensitivity": few,
            "direct": few,
        }
        cls.scene = hapdef.Scene(SHIN, results=OUT, threads=THREADS, amounts=amounts)
        cls.records = cls.scene.train()

    def test_stages_are_told_and_kept(self):
        names = [record["stage"] for record in self.records]
        self.assertEqual(names[:2], ["compliance", "rig"])
        again = self.scene.train()
        self.assertTrue(all(record["cached"] for record in again))
        self.assertEqual([record["folder"] for record in again], [r["folder"] for r in self.records])

    def test_the_table_is_the_stages_and_handed_over(self):
        table = self.scene.compliance()
        stored = tensor(self.records[0]["folder"] + "/compliance.safetensors", "displacement")
        np.testing.assert_array_equal(table.reshape(len(table), -1), stored)
        self.assertEqual(table.dtype, np.float32)
        # It is a view of memory that NumPy did not allocate: nothing was copied.
        owner = table
        while isinstance(owner.base, np.ndarray):
            owner = owner.base
        self.assertFalse(owner.flags.owndata)
        self.assertIsNotNone(owner.base)

    def test_the_trained_chain_finds_contacts(self):
        estimator = self.scene.estimator("hapdefx")
        self.assertEqual(estimator.name, "hapdefx")
        places = self.scene.surface_m[[500, 2500]]
        found = estimator.estimate(self.scene.response().readings_ue(places, [25.0, 25.0]))
        self.assertEqual(len(found), 2)
        self.assertTrue(np.isfinite(found.position_m).all())


class Courtesy(unittest.TestCase):
    def setUp(self):
        # a shell starts what runs in its background with Ctrl-C ignored
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)

    def test_other_threads_run_while_it_solves(self):
        scene = placed()
        ticks, done = [], threading.Event()

        def tick():
            while not done.wait(0.01):
                ticks.append(time.monotonic())

        ticker = threading.Thread(target=tick)
        ticker.start()
        start = time.monotonic()
        scene.response()
        elapsed_s = time.monotonic() - start
        done.set()
        ticker.join()
        self.assertGreater(len(ticks), 0.2 * elapsed_s / 0.01)

    @unittest.skipUnless(hasattr(signal, "raise_signal"), "needs signals")
    def test_ctrl_c_ends_it(self):
        scene = placed()
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            for _ in range(1000):
                scene.response()

    def test_ctrl_c_ends_a_loop_over_frames(self):
        with placed().live() as live:
            threading.Timer(0.3, _thread.interrupt_main).start()
            with self.assertRaises(KeyboardInterrupt):
                for _ in live:
                    pass


if __name__ == "__main__":
    unittest.main()
