"""A terminal of a given width, for programs that a person uses: what they write goes through
a pseudo-terminal, and the lines are kept as a screen shows them."""
import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import termios
import threading

# Cursor home, erase, colours, cursor shown or hidden.
_CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


class Terminal:
    """A program at a terminal; `wide`: the longest text that it wrote into one line."""

    def __init__(self, words, columns=80, cwd=None):
        self.words, self.columns = [str(word) for word in words], columns
        self._written = []
        self._master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        self.process = subprocess.Popen(self.words, stdin=slave, stdout=slave, stderr=slave,
                                        cwd=cwd, start_new_session=True)
        os.close(slave)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        while True:
            try:
                some = os.read(self._master, 65536)
            except OSError:  # the last holder of the other end has ended
                return
            if not some:
                return
            self._written.append(some)

    @property
    def text(self):
        """All of it, without control sequences."""
        whole = b"".join(self._written).decode(errors="replace")
        return _CONTROL.sub("", whole).replace("\r\n", "\n")

    @property
    def lines(self):
        """As they stand at the end: what a carriage return wrote over is gone."""
        return [line.split("\r")[-1].rstrip() for line in self.text.split("\n")]

    def redrawn(self):
        """The states of lines that were written over, and so are drawn to fit the width."""
        return [state.rstrip() for line in self.text.split("\n") if "\r" in line
                for state in line.split("\r") if state.strip()]

    def type(self, keys):
        os.write(self._master, keys.encode())

    def interrupt(self):
        os.killpg(self.process.pid, signal.SIGINT)

    def wait(self, seconds=120):
        """The exit code."""
        code = self.process.wait(timeout=seconds)
        self._reader.join(5)
        return code

    def close(self):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        os.close(self._master)
