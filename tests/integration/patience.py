"""Waiting for what happens in other processes."""
import time


def eventually(condition, seconds=60, pause_s=0.1):
    """The first true value of the condition; fails after the time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(pause_s)
    raise AssertionError(f"not within {seconds} s: {condition.__name__}")
