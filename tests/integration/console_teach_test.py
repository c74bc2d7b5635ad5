#!/usr/bin/python3
"""A machine that is taught over the console: by messages as a page sends them, and on the page in
a browser where one is installed. What is saved is read from the profile, what is lit from the
laser controller, and nothing fires.

  console_teach_test.py --bin FOLDER_OF_PROGRAMS --folder FOLDER
"""
import argparse
import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.error

from console_browser import missing
from console_jog_test import Finger, Shop, add_people
from console_teach_page import teach_on_the_page
from patience import eventually

LENS = "f43"
# What refuses an order until the machine's services have reported.
REPORTS_MISSING = re.compile("key and door are not known|no job service answers for this machine")
HEIGHT_MM = 30


class TaughtShop(Shop):
    def teaching(self):
        return json.loads(self.ask("GET", "machines/els-03/teaching")[1])

    def answers(self):
        try:
            return self.teaching()
        except urllib.error.HTTPError:
            return None  # no state of the machine has come yet

    def zero(self, channel=1):
        return next(zero for zero in self.teaching()["zeros"]
                    if zero["channel"] == channel and zero["lens"] == LENS)

    def profile(self):
        return (self.folder / "shop/machine.textproto").read_text()

    def typed(self, *words):
        return subprocess.run([self.bin / "intaglio", *words, *self.place], cwd=self.folder,
                              check=True, text=True, stdout=subprocess.PIPE).stdout

    def status(self):
        return json.loads(self.typed("teach", "status", "--json"))

    def cracks(self):
        return int(re.search(r'"cracks": (\d+)', self.ask_panel("status"))[1])

    def hold(self, finger, kind, until, seconds=5.0, **order):
        """As a page does it while a finger is on a button: to the answer, or `until` holds."""
        finger.press += 1
        finger.refusal = ""
        finger.send("")
        end = time.monotonic() + seconds
        fresh = 0
        while time.monotonic() < end and not finger.refusal:
            if not finger.read(0.6):
                finger.send("")
                continue
            fresh += 1
            view = finger.view
            if view["answered_press"] == finger.press and view["answer"] != "accepted":
                finger.send("")
                if view["answer"] == "refused" and REPORTS_MISSING.search(view["message"]):
                    finger.press += 1  # a busy computer: the person presses again
                    continue
                return view["answer"], view["message"]
            if fresh > 3:
                finger.send(kind, **order)
            else:
                finger.send("")
            if until():
                return "held", ""
        return "refused" if finger.refusal else "held", finger.refusal

    def does(self, finger, kind, **order):
        """To its answer. On a computer that is too busy for 200 ms the machine lets go, and the
        operator holds it again."""
        for _ in range(10):
            answer, message = self.hold(finger, kind, lambda: False, **order)
            if answer != "held" and "let go" not in message:
                return answer, message
        raise AssertionError(f"{kind}: no answer")


def never():
    return False


def check_limits(shop, finger):
    """Soft limits are set, kept in the profile and removed; wrong ones are refused."""
    def limits():
        return [(axis["limit_min"], axis["limit_max"]) for axis in shop.status()["axes"]]

    travel = limits()
    lowest = {axis: travel[i][0] + 5 for i, axis in enumerate("xyz")}
    highest = {f"{axis}_max": travel[i][1] - 4 for i, axis in enumerate("xyz")}
    answer, message = shop.does(finger, "save_limits", **lowest, **highest)
    assert answer == "done", message
    assert limits() == [(low + 5, high - 4) for low, high in travel], (travel, limits())
    assert "limits {" in shop.profile()
    answer, message = shop.does(finger, "save_limits", **lowest, x_max=lowest["x"] - 1)
    assert answer == "refused", (answer, message)
    answer, message = shop.does(finger, "forget_limits")
    assert answer == "done", message
    assert limits() == travel, (travel, limits())
    for _ in range(2):
        answer, message = shop.does(finger, "undo")
        assert answer == "done", message
    assert limits() == travel, (travel, limits())


def teach_by_messages(shop):
    finger = Finger(shop.port, shop.key)
    eventually(shop.answers, 30)
    before, text = shop.teaching(), shop.profile()
    assert [lens["name"] for lens in before["lenses"]] == ["f43", "f70"], before
    assert before["channels"] == 4 and len(before["zeros"]) == 8, before
    assert not any(zero["taught"] for zero in before["zeros"]), before
    place = [axis["position"] for axis in shop.status()["axes"]]

    observer = Finger(shop.port, shop.observer)
    for kind in ("save_zero", "save_limits", "undo", "lamp", "shutter"):
        answer, message = shop.hold(observer, kind, never, lens=LENS, z=HEIGHT_MM, channel=1)
        assert answer == "refused" and "an observer" in message, (kind, answer, message)
    assert shop.profile() == text, "an observer teaches nothing"

    answer, message = shop.does(finger, "save_zero", lens=LENS, channel=2, z=HEIGHT_MM)
    assert answer == "done", message
    zero = shop.zero(2)
    assert zero["taught"], zero
    # The focus is at the top corner of a block of 30 mm, with the axes where they are.
    assert abs(zero["z_mm"] - (place[2] - HEIGHT_MM)) < 0.01, (zero, place)
    assert not shop.zero(1)["taught"], "channel 1 keeps that of the profile"
    taught = shop.teaching()
    assert taught["taught_number"] == shop.status()["taught_number"] == 1, taught
    assert "zero of channel 2, lens f43" in taught["taught_change"], taught
    assert taught["taught_change"] in shop.typed("teach", "history"), taught

    # Of x alone, and moved by a way.
    answer, message = shop.does(finger, "move_zero", lens=LENS, channel=2, x=0.25, sets=1)
    assert answer == "done", message
    assert abs(shop.zero(2)["x_mm"] - zero["x_mm"] - 0.25) < 1e-6
    assert shop.zero(2)["z_mm"] == zero["z_mm"]
    for _ in range(2):
        answer, message = shop.does(finger, "undo")
        assert answer == "done", message
    assert not shop.zero(2)["taught"]
    check_limits(shop, finger)
    answer, message = shop.does(finger, "save_zero", lens="f99", channel=1)
    assert answer == "refused" and "f99" in message, message

    # A sample of what was seen long ago, as one that a network held back, saves nothing.
    text = shop.profile()
    old = dict(finger.view)
    time.sleep(0.5)
    finger.press += 1
    for _ in range(10):
        finger.view = dict(old)
        finger.send("save_zero", lens=LENS, channel=2)
        time.sleep(0.02)
    time.sleep(0.5)
    assert shop.profile() == text, "it is saved by a state of half a second ago"
    print("zeros are saved, moved and undone by who may", flush=True)


def light_by_messages(shop):
    """Lamp and shutter are on while a finger is down, and go out by themselves."""
    def lamp():
        return shop.status()["lamp_on"]

    def shutters():
        return shop.status()["shutters_open"]

    def cut(finger):
        finger.socket.close()

    def door(_finger):
        shop.ask_panel("door force")

    for kind, is_on in (("lamp", lamp), ("shutter", shutters)):
        for end in (cut, door):
            for _ in range(5):
                finger = Finger(shop.port, shop.key)
                on = {}

                def lit():
                    on["it is"] = is_on_now(finger, kind)
                    return on["it is"]

                answer, message = shop.hold(finger, kind, lit, channel=2)
                if answer == "held" and on.get("it is"):
                    break
            assert answer == "held" and on["it is"], (kind, answer, message)
            end(finger)
            eventually(lambda: not is_on(), 10)
            if end is door:
                finger = Finger(shop.port, shop.key)
                answer, message = shop.does(finger, kind, channel=2)
                assert answer in ("refused", "stopped") and "door" in message, message
                assert not is_on(), f"{kind}: it is lit at an open door"
                shop.ask_panel("door close")
                eventually(lambda: shop.status()["door_closed"], 10)
                time.sleep(1)
                assert not is_on(), f"{kind}: it is lit again when the door closes"
    assert shop.cracks() == 0, "no pulse is fired"
    print("lamp and shutter are lit while they are held", flush=True)


BLOCK = {"block_x_mm": 50, "block_y_mm": 50, "block_z_mm": 30}


def test_jobs_by_requests(shop):
    """Who may, what is refused, and that the same request again is the same job."""
    def asks(kind, header=None, **body):
        try:
            return 200, json.loads(shop.ask("POST", f"machines/els-03/{kind}", body, header)[1])
        except urllib.error.HTTPError as error:
            return error.code, json.loads(error.read())

    status, answer = asks("pulse", shop.observer, id="p1", **BLOCK)
    assert (status, answer["code"]) == (403, "not_operator"), answer
    status, answer = asks("pulse", shop.other, id="p1", **BLOCK)
    assert (status, answer["code"]) == (409, "not_in_charge"), answer
    for kind, body, reason in (
            ("pulse", {}, "block: give its size"),
            ("pulse", {**BLOCK, "lens": "f99"}, "f99"),
            ("pulse", {**BLOCK, "channel": 5}, "channels 1 to 4"),
            ("pulse", {**BLOCK, "glass": "N-BK"}, "N-BK7"),
            ("focus", {**BLOCK, "count": 1}, "2 to 1000 points"),
            ("focus", {**BLOCK, "step_mm": 5}, "deeper than the block")):
        status, answer = asks(kind, id="wrong", **body)
        assert status == 422 and reason in answer["message"], (kind, body, status, answer)
    shop.typed("teach", "move", "12", "17", "28", "--speed", "50")
    time.sleep(1)
    status, answer = asks("pulse", id="p1", **BLOCK)
    assert status == 200 and answer["submitted"], answer
    again = asks("pulse", id="p1", **BLOCK)[1]
    assert again["job"] == answer["job"], "the same again submits nothing"
    shop.ask("POST", f"jobs/{answer['job']}/cancel", {})
    print("test jobs are for who is in charge", flush=True)


def is_on_now(finger, kind):
    return finger.view["lamp_by_hand"] if kind == "lamp" else finger.view["shutters_by_hand"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    add_people(given)
    shop = TaughtShop(given)
    try:
        shop.open_console()
        shop.observer = shop.log_in("olga", "correct horse")
        shop.other = shop.log_in("bert", "correct horse")
        teach_by_messages(shop)
        light_by_messages(shop)
        test_jobs_by_requests(shop)
        if missing():
            print("not in a browser; not installed:", ", ".join(missing()))
        else:
            teach_on_the_page(shop, given.folder)
    finally:
        shop.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
