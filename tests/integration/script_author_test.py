#!/usr/bin/env python3
"""The week of a script author: lists of jobs, ids that make a retry harmless, JSON and
events everywhere, exit codes, and a code for each refusal.

    script_author_test.py --intaglio build/release/bin/intaglio --folder /tmp/author
"""
import json

from at_terminal import InAShop, main
from patience import eventually

LIST = "id,name,models[0].placement.fit_height_mm,priority\na,one,4,0\nb,two,5,1\n"
BAD = ("id,name,models[0].placement.fit_height_mm,glass\n"
       "a,one,abc,N-BK7\nb,two,5,N-BK8\na,three,4.5,\nd,{name},4.5,\n")


class ScriptAuthor(InAShop):
    domain = "52"

    def events(self, *words, exit_code=0):
        """The events of a command, each with all fields; the text is on the other stream."""
        written, _ = self.scripted(*words, "--events", exit_code=exit_code)
        events = [json.loads(line) for line in written.splitlines()]
        for event in events[1:]:
            self.assertEqual(event.keys(), events[0].keys())
        return events

    def test_1_every_refusal_has_a_code_a_sentence_and_the_exit_code_of_its_kind(self):
        for code, words, says in (
                ("not_found", ["submit", "nothing.textproto"], "supplied jobs"),
                ("invalid_value", ["submit", "knot.textproto", "--spacing", "abc"], "number"),
                ("invalid_value", ["submit", "knot.textproto", "--glas", "K9"], "--glass"),
                ("invalid_value", ["submit", "knot.textproto", "--id", "a b"], "letters"),
                ("invalid_value", ["submit", "knot.textproto", "--same-block"], "--arm"),
                ("not_found", ["show", "99"], "known jobs"),
                ("not_found", ["arm", "99"], "known jobs"),
                ("not_found", ["again", "99", "--folder", "shop"], "no job"),
                ("not_found", ["history", "--folder", "nowhere"], "--folder"),
                ("not_found", ["batch", "none.csv"], "does not exist"),
                ("timed_out", ["list", "--domain", "53"], "intaglio up"),
                ("invalid_value", ["list", "--domain", "999"], "--domain"),
                ("missing", ["list", "--interface", "eth0"], "--security"),
                ("missing", ["run", "sample", "--interface", "eth0", "--out", "made"],
                 "--security"),
                ("not_found", ["list", "--security", "nowhere"], "intaglio security new")):
            with self.subTest(words=words):
                self.assertIn(says, self.refused(code, *words))
        event, = self.events("watch", "99", exit_code=2)
        self.assertEqual((event["event"], event["code"]), ("refused", "not_found"))

    def test_2_a_list_is_checked_as_a_whole(self):
        (self.folder / "bad.csv").write_text(BAD)
        check = ["batch", "bad.csv", "--job", "knot.textproto", "--check"]
        sentence = self.refused("invalid_value", *check)
        for line in ("line 2 (a): models[0].placement.fit_height_mm", "line 3 (b): glass",
                     "line 4: id 'a'", "line 5 (d): name"):
            self.assertIn(line, sentence)
        event, = self.events(*check, exit_code=2)
        self.assertEqual((event["event"], event["message"]), ("refused", sentence))
        (self.folder / "one.csv").write_text("id,name\na,one\n")
        good = ["batch", "one.csv", "--job", "knot.textproto", "--check"]
        self.assertEqual(self.answered(*good)["message"], "1 job, all without mistakes")
        self.assertEqual(self.events(*good), [], "a sentence is no event")

    def test_3_an_id_makes_a_retry_harmless(self):
        first = self.answered("submit", "knot.textproto", "--id", "order-1")
        self.assertEqual((first["taken"], first["code"]), (True, "taken"))
        again = self.answered("submit", "knot.textproto", "--id", "order-1")
        self.assertEqual(again["job"], first["job"])
        other = self.answered("submit", "knot.textproto", "--spacing", "0.6", "--id", "order-1",
                              exit_code=2)
        self.assertFalse(other["taken"])
        self.assertIn(f"job {first['job']}", other["message"])
        self.assertEqual(len(self.answered("list")["jobs"]), 1)
        self.assertEqual(self.answered("arm", first["job"])["code"], "taken")
        events = self.events("watch", first["job"])
        ended = events[-1]
        self.assertEqual((ended["event"], ended["verdict"]), ("ended", "good"))
        counts = [ended[name] for name in ("made", "missed", "skipped", "uncertain")]
        self.assertEqual((sum(counts), counts[0]), (ended["planned"], ended["planned"]))
        self.assertEqual(self.refused("ended_job", "cancel", first["job"]),
                         f"job {first['job']} is already done")

    def test_4_a_batch_goes_on_where_it_ended(self):
        (self.folder / "list.csv").write_text(LIST)
        made = ["batch", "list.csv", "--job", "knot.textproto", "--arm", "--same-block"]
        screen = self.typed(*made, "--results", "first.json")
        self.assertIn("2 jobs in ", screen)
        self.assertTrue(all(len(line) <= 80 for line in screen.splitlines()), screen)
        first = json.loads((self.folder / "first.json").read_text())
        jobs = {row["id"]: row["job"] for row in first["jobs"]}
        self.assertLess(jobs["b"], jobs["a"], "the higher priority is made first")
        (self.folder / "list.csv").write_text(LIST + "c,three,4,0\n")
        events = self.events(*made, "--continue", "first.json", "--results", "next.json")
        self.assertEqual({event["id"] for event in events}, {"c", ""}, "the others are done")
        self.assertEqual((events[-1]["event"], events[-1]["done"]), ("summary", 3))
        after = json.loads((self.folder / "next.json").read_text())
        self.assertEqual(after["good"], 3)
        self.assertEqual({row["id"]: row["job"] for row in after["jobs"][:2]}, jobs)
        rows = {row["job"]: row for row in self.answered("history", "--folder", "shop")["jobs"]}
        for row in after["jobs"]:
            self.assertEqual(rows[row["job"]]["verdict"], row["verdict"])
        (self.folder / "list.json").write_text("no results")
        self.refused("unreadable", *made, "--continue", "list.json")

    def test_5_a_script_reads_why_a_job_is_not_armed(self):
        events = self.events("submit", "knot.textproto", "--block", "60", "30", "20", "--arm",
                             "--watch", exit_code=4)
        self.answered("cancel", events[0]["job"])
        self.assertEqual([event["event"] for event in events], ["submitted", "refused"])
        self.assertEqual(events[1]["job"], events[0]["job"])
        self.assertTrue(events[1]["code"])
        self.assertIn("60 x 30 x 20", events[1]["message"])

    def test_6_what_becomes_of_a_job_is_told_alike_everywhere(self):
        job = self.answered("submit", "knot.textproto")["job"]
        def state():
            return self.answered("show", job)
        eventually(lambda: state()["state"] == "waiting_for_arm")
        self.assertEqual(self.answered("status", exit_code=4)["needs_person"], True)
        self.assertEqual(self.answered("cancel", job)["message"],
                         f"job {job} is cancelled: {state()['message']}")
        ended = self.events("watch", job, exit_code=5)[-1]
        shown = eventually(lambda: state()["verdict"] and state())
        row = next(row for row in self.answered("list")["jobs"] if row["job"] == job)
        for told in (ended, shown, row):
            self.assertEqual((told["state"], told["verdict"], told["made"]),
                             ("cancelled", "none", 0))
        self.assertEqual(self.answered("status")["needs"], [])


if __name__ == "__main__":
    main(__doc__)
