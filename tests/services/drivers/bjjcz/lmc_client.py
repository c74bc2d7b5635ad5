#!/usr/bin/env python3
"""Another host of a BJJCZ board, written from the public descriptions of its protocol.

It shares no code with the product. It makes points with a UV laser: it reads lines
"x_mm y_mm steps" and sends one list a layer of the axis.
    lmc_client.py SOCKET POINTS FIELD_MM JUMP_MM_S JUMP_DELAY_US DWELL_US FREQUENCY_HZ
"""
import itertools
import socket
import struct
import sys
import time

BUSY, READY, AXIS = 0x04, 0x20, 0x40


class Board:
    def __init__(self, path):
        self.line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.line.settimeout(10)
        self.line.connect(path)

    def ask(self, operation, *arguments):
        """A realtime command; the four numbers of its answer."""
        words = (operation, *arguments, 0, 0, 0, 0, 0)[:6]
        self.line.sendall(struct.pack("<6H", *words))
        answer = b""
        while len(answer) < 8:
            answer += self.line.recv(8 - len(answer))
        return struct.unpack("<4H", answer)

    def wait_while(self, bits):
        while self.ask(0x0007)[3] & bits:
            time.sleep(0.002)

    def wait_for(self, bits):
        while not self.ask(0x0007)[3] & bits:
            time.sleep(0.002)

    def start(self):
        self.ask(0x0009)
        self.ask(0x0007)
        self.ask(0x0040)
        self.ask(0x0015, 0)
        for command in ((0x0004,), (0x0016, 0), (0x001B, 1), (0x0017, 1), (0x001C, 1),
                        (0x001D, 2000, 20), (0x001A, 200), (0x001E, 125), (0x0006, 125),
                        (0x002E, 0xFFB, 1, 409, 100), (0x0032, 0, 99, 1000, 25),
                        (0x003A,), (0x0022, 0x7FF), (0x003A,)):
            self.ask(*command)

    def move_axis(self, steps):
        number = abs(steps) | (0x80000000 if steps < 0 else 0)
        self.ask(0x0026, 20000, 20000)
        self.ask(0x0027, 20)
        self.ask(0x0029, number & 0xFFFF, number >> 16)
        self.wait_while(AXIS)

    def play(self, commands):
        """Fills packets with 8002; executes behind the third, or at the end."""
        self.ask(0x0012)
        packets = [commands[at:at + 256] for at in range(0, len(commands), 256)]
        executed = False
        for number, packet in enumerate(packets, 1):
            packet = packet + [(0x8002,)] * (256 - len(packet))
            self.wait_for(READY)
            self.line.sendall(b"".join(
                struct.pack("<6H", *(tuple(one) + (0,) * 6)[:6]) for one in packet))
            self.ask(0x0019, 0)
            if not executed and (number == 3 or number == len(packets)):
                self.ask(0x0005)
                executed = True
        self.wait_while(BUSY)


def main():
    path, points_file = sys.argv[1:3]
    field_mm, jump_mm_s, jump_delay_us, dwell_us, frequency_hz = map(float, sys.argv[3:])
    units_a_mm = 65536 / field_mm
    with open(points_file, encoding="ascii") as lines:
        points = [(float(x), float(y), int(steps))
                  for x, y, steps in (line.split() for line in lines)]
    board = Board(path)
    board.start()
    board.ask(0x0021, 1)  # output 0 gates the laser
    at = (32768, 32768)
    for steps, layer in itertools.groupby(points, key=lambda point: point[2]):
        board.move_axis(steps)
        commands = [(0x8051,), (0x8006, round(jump_mm_s * units_a_mm / 1000)),
                    (0x800D, round(jump_delay_us)),
                    (0x800A, round(10e6 / frequency_hz)), (0x801E, 67, 67),
                    (0x800B, 240)]
        for x, y, _ in layer:
            to = (round(32768 + x * units_a_mm), round(32768 + y * units_a_mm))
            way = ((to[0] - at[0]) ** 2 + (to[1] - at[1]) ** 2) ** 0.5
            commands.append((0x8001, to[0], to[1], 0, min(65535, round(way))))
            commands.append((0x8003, round(dwell_us / 10)))
            at = to
        board.play(commands + [(0x8002,)])
    board.ask(0x0021, 0)
    board.ask(0x0041, 3)


if __name__ == "__main__":
    main()
