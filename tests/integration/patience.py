"""Waiting for what happens in other processes."""
import time


def eventually(condition, seconds=240, pause_s=0.1):
    """The first true value of the condition; fails after the time. It ends a hang, and is long
    because other tests may leave this one a quarter of the computer."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(pause_s)
    raise AssertionError(f"not within {seconds} s: {condition.__name__}")
