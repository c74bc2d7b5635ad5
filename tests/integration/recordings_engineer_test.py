#!/usr/bin/env python3
"""The week of an engineer of recordings: what a night's recording has, what a cut file has
lost, one job of several, and whether today's programs do the same again.

    recordings_engineer_test.py --intaglio build/release/bin/intaglio --folder /tmp/recordings
"""
import json
import shutil

from at_terminal import SOURCE, InAShop, main
from patience import eventually

DATA = SOURCE / "tests/data/recordings"


class EngineerOfRecordings(InAShop):
    domain = "54"

    def recording(self, *words, exit_code=0):
        return self.typed("recording", *words, exit_code=exit_code)

    def makes(self, *options):
        """One job to its end."""
        submitted = self.answered("submit", "knot.textproto", "--arm", "--same-block", *options)
        self.assertTrue(submitted["taken"], submitted)
        self.typed("watch", submitted["job"])
        return self.answered("show", submitted["job"])

    def test_1_a_night_of_two_jobs(self):
        nowhere = self.typed("record", "--out", "nowhere/night.mcap", exit_code=2)
        self.assertIn("check the folder", nowhere)
        self.assertNotIn("records into", nowhere, "nothing is recorded")
        record = self.open("record", "--out", "night.mcap")
        eventually(lambda: "records into night.mcap" in record.text)
        jobs = [self.makes(), self.makes("--height", "3")]
        self.assertEqual([job["verdict"] for job in jobs], ["good", "good"])
        record.interrupt()
        self.assertEqual(record.wait(), 0, record.text)
        self.check_what_is_in_it()
        self.check_one_job_of_it(jobs)
        self.check_spans()
        self.check_the_same_again()

    def check_what_is_in_it(self):
        info = self.answered("recording", "info", "night.mcap")
        self.assertEqual((info["whole"], info["missing"], info["damages"]), (True, [], []))
        self.assertRegex(self.recording("info", "night.mcap"), r"state +whole\n")
        rows = self.recording("list", "night.mcap").splitlines()
        channels = self.answered("recording", "list", "night.mcap")["channels"]
        place = rows[0].index("type")
        for row, channel in zip(rows[1:], channels):
            self.assertEqual(row[place:], channel["type"], "columns stand below their titles")

    def check_one_job_of_it(self, jobs):
        export = ["export", "night.mcap", "--format", "ply", "--out", "cracks.ply"]
        both = self.recording(*export, exit_code=2)
        for job in jobs:
            self.assertIn(job["uid"], both)
        self.assertFalse((self.folder / "cracks.ply").exists())
        for job in jobs:
            for name in (job["job"], job["uid"]):
                self.recording(*export, "--job", name)
                head = (self.folder / "cracks.ply").read_bytes()[:200].decode(errors="replace")
                self.assertIn(f"element vertex {job['made']}\n", head.replace("\r", ""))
        self.assertIn("it has 1-", self.recording(*export, "--job", "99", exit_code=2))
        lost = self.recording("export", "night.mcap", "--job", "1", "--out", "all.jsonl",
                              exit_code=2)
        self.assertIn("--job is for --format ply", lost)
        self.assertFalse((self.folder / "all.jsonl").exists())
        table = self.scripted("recording", "export", "night.mcap", "--format", "csv",
                              "--topic", "JobStatus")[0]
        self.assertIn("counts.made", table.splitlines()[0])
        self.assertIn("recording list", self.recording(
            "export", "night.mcap", "--topic", "JobStates", exit_code=2))

    def check_spans(self):
        end = self.answered("recording", "info", "night.mcap")["duration_s"]
        for words in (["cut", "night.mcap", "--from", "900"],
                      ["cut", "night.mcap", "--from", "3", "--to", "2"],
                      ["export", "night.mcap", "--from", "900"]):
            self.refused("invalid_value", "recording", *words)
        self.assertIn(f"ends {end:.1f} s after", self.refused(
            "invalid_value", "replay", "night.mcap", "--tag", "other", "--start", "900"))
        self.assertIn("has no such topic", self.refused(
            "not_found", "replay", "night.mcap", "--tag", "other", "--topic", "JobStates"))
        self.assertIn("recording needs a command: info, list", self.typed("recording", exit_code=2))
        self.assertFalse((self.folder / "night-cut.mcap").exists())
        self.assertRegex(self.recording("cut", "night.mcap", "--from", "1", "--to", "2"),
                         r"^[1-9][0-9 ]* messages in night-cut.mcap")

        whole = self.answered("recording", "info", "night.mcap")["message_count"]
        self.assertIn("that two of the files have written once",
                      self.recording("merge", "night.mcap", "night-cut.mcap"))
        merged = self.answered("recording", "info", "night-merged.mcap")
        self.assertEqual(merged["message_count"], whole)

    def check_the_same_again(self):
        same = self.typed("replay", "night.mcap", "--against", "sorter")
        self.assertRegex(same, r"2 tasks.*\n(.*\n)*verdict +IDENTICAL")
        other = self.answered("replay", "night.mcap", "--against", "discretizer", "--set",
                              "discretization.min_spacing_mm=0.6", exit_code=3)
        self.assertEqual((other["identical"], other["cause"]), (False, "option"), other)

    def test_2_a_file_that_was_cut_off(self):
        whole = (self.folder / "night.mcap").read_bytes()
        (self.folder / "cut.mcap").write_bytes(whole[:len(whole) * 6 // 10])
        cut = self.answered("recording", "info", "cut.mcap")
        self.assertFalse(cut["whole"])
        self.assertGreater(cut["message_count"], 0)
        lost = int(cut["torn_bytes"])
        self.assertGreater(lost, 0)
        self.assertIn("the copy was truncated", self.recording("info", "cut.mcap"))
        repaired = self.recording("repair", "cut.mcap")
        digits = f"{lost:,}".replace(",", " ")
        self.assertIn(f"left out    cut.mcap: {digits} bytes at its end are incomplete", repaired)
        self.assertRegex(repaired, r"[0-9] messages in cut-repaired.mcap")
        after = self.answered("recording", "info", "cut-repaired.mcap")
        self.assertEqual((after["whole"], after["message_count"]), (True, cut["message_count"]))
        two_makers = (DATA / "two_makers.mcap").read_bytes()
        (self.folder / "none_left.mcap").write_bytes(two_makers[:len(two_makers) // 2])
        self.assertIn("nothing to compare", self.refused(
            "missing", "replay", "none_left.mcap", "--against", "synchronizer"))
        shutil.copy(DATA / "two_makers.textproto", self.folder)
        for code, name in (("unreadable", "two_makers.textproto"), ("not_found", "none.mcap")):
            for command in (["recording", "info"], ["recording", "repair"], ["replay"]):
                self.refused(code, *command, name)

    def test_3_a_recorder_beside_no_shop_says_so(self):
        record = self.open("record", "--out", "nothing.mcap", "--tag", "nobody")
        eventually(lambda: "records into nothing.mcap" in record.text)
        record.interrupt()
        self.assertEqual(record.wait(), 0, record.text)
        self.assertIn("nothing was received; check that a shop is open", record.text)


if __name__ == "__main__":
    main(__doc__)
