#!/usr/bin/python3
"""Webhooks of a real console beside a real shop: what receivers get is what the stream of
events has, in its order, signed as Python's own hmac signs it, whatever other receivers do.

  console_webhooks_test.py --bin FOLDER_OF_PROGRAMS --folder FOLDER [--resolver-shim LIBRARY]
"""
import argparse
import hashlib
import hmac
import http.server
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import threading
import urllib.request

from patience import eventually

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SECRET = "0123456789abcdef0123456789abcdef"
PLACE = ["--domain", "49", "--tag", f"hooks{os.getpid()}"]


def documented():
    """The list, the commands and the receiver of the page, as they stand there."""
    text = (ROOT / "docs/console.md").read_text().split("### Webhooks\n")[1].split("\n## ")[0]
    return [block for _, block in re.findall(r"```(\w*)\n(.*?)```", text, re.S)]


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Receiver:
    """Keeps each attempt whose signature is right; answers `statuses` and then the last one."""

    def __init__(self, statuses, certificate=None):
        self.attempts, self.accepted, self.wrong = [], [], []
        kept = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                signed = self.headers["Intaglio-Timestamp"].encode() + b"." + body
                code = hmac.new(SECRET.encode(), signed, hashlib.sha256).hexdigest()
                if self.headers["Intaglio-Signature"] != f"v1={code}":
                    kept.wrong.append(dict(self.headers))
                status = statuses[min(len(kept.attempts), len(statuses) - 1)]
                kept.attempts.append((self.headers["Intaglio-Delivery"], body.decode()))
                if status < 300:
                    kept.accepted.append((self.headers["Intaglio-Delivery"], body.decode()))
                    assert self.headers["Intaglio-Event"] == json.loads(body)["event"]
                self.send_response(status)
                self.send_header("Location", f"http://127.0.0.1:{kept.port}/elsewhere")
                self.send_header("Content-Length", "4")
                self.end_headers()
                self.wfile.write(b"done")

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        if certificate:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*certificate)
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
        self.port = self.server.server_port
        self.url = f"http{'s' if certificate else ''}://127.0.0.1:{self.port}/secret-path"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def bodies(self):
        return [body for _, body in self.accepted]


class Silent:
    """Accepts connections, and never answers."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}/"
        self.lines = []
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            line, _ = self.listener.accept()
            line.setblocking(False)
            self.lines.append(line)

    def holds_one(self):
        """A transfer waits for its answer now."""
        for line in self.lines:
            try:
                while line.recv(65536):
                    pass
            except BlockingIOError:
                return True
        return False


def receiver_text(name, url, more=""):
    return f'receivers {{ name: "{name}" url: "{url}" secret_file: "secret" {more} }}\n'


class Console:
    def __init__(self, given, hooks):
        self.folder = given.folder
        self.log = self.folder / "console.txt"
        # A proxy of the environment, where nobody answers, does not count.
        more = {name: "http://127.0.0.1:9" for name in ("http_proxy", "https_proxy", "all_proxy")}
        if given.resolver_shim:
            more["LD_PRELOAD"] = str(given.resolver_shim)
        self.process = subprocess.Popen(
            [given.bin / "intaglio-console", "--address-file", "console.address", "--webhooks",
             hooks, *PLACE], cwd=self.folder, env={**os.environ, **more},
            stdout=open(self.log, "w"), stderr=subprocess.STDOUT)

        def is_open():
            assert self.process.poll() is None, self.log.read_text()
            return "the console is open" in self.log.read_text()

        eventually(is_open)
        address = (self.folder / "console.address").read_text()
        self.url = re.match(r"(http://[^/]*)/", address)[1]
        self.key = re.search(r"key=(\w+)", address)[1]
        self.events = []
        threading.Thread(target=self.follow, args=[self.open("/api/v1/events")],
                         daemon=True).start()

    def open(self, path, body=None):
        request = urllib.request.Request(self.url + path, data=body)
        request.add_header("Authorization", "Bearer " + self.key)
        return urllib.request.urlopen(request, timeout=120)

    def ask(self, path, body=None):
        with self.open(path, body) as answer:
            return answer.read().decode()

    def follow(self, stream):
        try:
            for line in stream:
                if line.startswith(b"data: "):
                    self.events.append(line[6:].decode().rstrip("\n"))
        except OSError:
            pass  # the console has ended

    def of_kinds(self, *kinds):
        return [line for line in self.events if json.loads(line)["event"] in kinds]

    def metric(self, name, receiver):
        found = re.search(rf'^intaglio_webhook_{name}{{receiver="{receiver}"}} (\d+)$',
                          self.ask("/metrics"), re.M)
        return int(found[1])

    def end(self):
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(20) == 0


def run(given, *words):
    return subprocess.run([given.bin / words[0], *words[1:]], cwd=given.folder, text=True,
                          capture_output=True, timeout=120)


def check_refusals(given):
    """A wrong list ends the console with a sentence, before it serves."""
    hooks = given.folder / "wrong.textproto"

    def refused(text, remedy):
        hooks.write_text(text)
        done = run(given, "intaglio-console", "--webhooks", "wrong.textproto", *PLACE)
        assert done.returncode == 2 and remedy in done.stderr, done.stderr
        assert SECRET not in done.stderr, done.stderr

    refused(receiver_text("a", "http://erp.example/"), "allow_plain_http")
    refused(receiver_text("a", "https://erp.example/", 'events: "end"'), '"end" is no kind')
    (given.folder / "secret").chmod(0o644)
    refused(receiver_text("a", "https://erp.example/"), "chmod 600")
    (given.folder / "secret").chmod(0o600)
    (given.folder / "secret").chmod(0o640)
    done = run(given, "intaglio-console", "--webhooks", "wrong.textproto", "--ping-webhook", "a")
    assert done.returncode == 2 and "chmod 600" in done.stderr, done.stderr
    (given.folder / "secret").chmod(0o600)
    done = run(given, "intaglio-console", "--ping-webhook", "a", *PLACE)
    assert done.returncode == 2 and "--webhooks" in done.stderr, done.stderr


def start_documented_receiver(given, port):
    return subprocess.Popen(["/usr/bin/python3", "receiver.py", str(port), "shop/orders.secret"],
                            cwd=given.folder, stdout=open(given.folder / "received.txt", "a"),
                            stderr=subprocess.DEVNULL)


def check_documented(given, port):
    """The list, the first commands and the receiver of the page; its process."""
    receivers, commands, program = documented()
    (given.folder / "receiver.py").write_text(program)
    text = receivers.replace("8901", str(port))
    assert text != receivers
    (given.folder / "shop").mkdir()
    (given.folder / "shop/webhooks.textproto").write_text(text)
    new_secret, ping, up = commands.splitlines()
    assert "--console-webhooks shop/webhooks.textproto" in up, up
    subprocess.run(["/bin/sh", "-ec", new_secret], cwd=given.folder, check=True)
    nobody = run(given, *ping.split())
    assert nobody.returncode == 1 and "no answer" in nobody.stderr, nobody.stderr
    process = start_documented_receiver(given, port)
    eventually(lambda: run(given, *ping.split()).returncode == 0)
    assert "ping" in (given.folder / "received.txt").read_text()
    done = run(given, *ping.split())
    assert f"orders (http://127.0.0.1:{port}): answered 204" in done.stdout, done.stdout
    # With another secret it is refused, and what the receiver answered is printed.
    (given.folder / "other.textproto").write_text(text.replace("orders.secret", "../secret"))
    (given.folder / "other.textproto").rename(given.folder / "shop/other.textproto")
    other = run(given, *ping.replace("webhooks.text", "other.text").split())
    assert other.returncode == 1 and "answered 401" in other.stderr, other.stderr
    unknown = run(given, *ping.replace("webhook orders", "webhook other").split())
    assert unknown.returncode == 2 and "give one of orders" in unknown.stderr, unknown.stderr
    return process


def make_certificate(folder, name):
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                    "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", "/CN=hook",
                    "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", folder / f"{name}.key",
                    "-out", folder / f"{name}.pem"], check=True, capture_output=True)
    return folder / f"{name}.pem", folder / f"{name}.key"


def submit_and_cancel(given, number):
    """A job from its submission to its end."""
    submitted = run(given, "intaglio", "submit", "sample", "--height", "4.2", "--spacing",
                    "0.5", *PLACE)
    assert submitted.returncode == 0, submitted.stderr
    eventually(lambda: "waiting_for_arm" in
               run(given, "intaglio", "show", str(number), "--json", *PLACE).stdout)
    cancelled = run(given, "intaglio", "cancel", str(number), *PLACE)
    assert cancelled.returncode == 0, cancelled.stderr


def check_deliveries(given, port, documented_process):
    """Returns the process of the documented receiver, which was killed and started again."""
    folder = given.folder
    trusted, strange = make_certificate(folder, "trusted"), make_certificate(folder, "strange")
    flaky, gone, moved = Receiver([500, 500, 200]), Receiver([410]), Receiver([302])
    secure, other = Receiver([200], trusted), Receiver([200], strange)
    silent = Silent()
    orders = (folder / "shop/webhooks.textproto").read_text().replace("orders.s", "shop/orders.s")
    (folder / "hooks.textproto").write_text(
        receiver_text("silent", silent.url) + receiver_text("flaky", flaky.url) +
        receiver_text("gone", gone.url) + receiver_text("moved", moved.url) +
        receiver_text("secure", secure.url, 'ca_file: "trusted.pem"') +
        receiver_text("other", other.url, 'ca_file: "trusted.pem"') +
        (receiver_text("unresolved", "https://never.example/") if given.resolver_shim else "") +
        receiver_text("absent", f"http://127.0.0.1:{free_port()}/") + orders)
    console = Console(given, "hooks.textproto")
    try:
        submit_and_cancel(given, 1)
        eventually(lambda: console.of_kinds("ended"))
        # Everything, in order, also beside those that do not get anything.
        eventually(lambda: flaky.bodies() == console.events and silent.lines)
        assert console.of_kinds("state"), console.events
        first = flaky.attempts[0]
        assert flaky.attempts[:3] == [first] * 3, flaky.attempts[:4]
        assert len(set(flaky.accepted)) == len(flaky.accepted)
        eventually(lambda: secure.bodies() == console.events)
        # A receiver that is killed gets what it has missed, in order, and once.
        eventually(lambda: (folder / "received.txt").read_text().count("ended 1") == 1)
        eventually(lambda: console.metric("waiting", "orders") == 0)
        documented_process.kill()
        documented_process.wait()
        # A name server that does not answer holds up nobody else.
        if given.resolver_shim:
            eventually(lambda: console.metric("failed_attempts_total", "unresolved") > 0)
        submit_and_cancel(given, 2)
        eventually(lambda: len(console.of_kinds("ended")) == 2)
        eventually(lambda: console.metric("failed_attempts_total", "orders") >= 2)
        documented_process = start_documented_receiver(given, port)
        eventually(lambda: (folder / "received.txt").read_text().count("ended 2") == 1)
        printed = [line.split()[:2] for line in (folder / "received.txt").read_text().splitlines()
                   if not line.startswith("ping")]
        sent = map(json.loads, console.of_kinds("submitted", "ended"))
        assert printed == [[event["event"], str(event["job"])] for event in sent], printed
        eventually(lambda: flaky.bodies() == console.events)
        check_figures(console, flaky, secure, other, gone, moved)
        check_answers_while_one_hangs(console, silent)
    finally:
        console.end()
    return documented_process


def check_answers_while_one_hangs(console, silent):
    """Within one attempt, of which nothing is answered."""
    before = len(silent.lines)
    eventually(lambda: len(silent.lines) > before and silent.holds_one())
    for _ in range(20):
        console.ask("/api/v1/status")
    assert '"confirmed": true' in console.ask("/api/v1/stop", b"{}")
    assert silent.holds_one() and len(silent.lines) == before + 1


def check_figures(console, flaky, secure, other, gone, moved):
    count = len(console.events)
    for name in ("flaky", "secure"):
        eventually(lambda n=name: console.metric("delivered_total", n) == count)
        assert console.metric("waiting", name) == console.metric("dropped_total", name) == 0
    assert console.metric("failed_attempts_total", "flaky") == 2
    for name in ("silent", "moved", "other", "absent"):
        assert console.metric("delivered_total", name) == 0, name
        assert console.metric("waiting", name) == count, name
        eventually(lambda n=name: console.metric("failed_attempts_total", n) > 0)
    assert console.metric("receiver_ended", "gone") == 1
    assert console.metric("receiver_ended", "flaky") == 0
    assert console.metric("dropped_total", "gone") == count and len(gone.attempts) == 1
    assert other.attempts == [], "its certificate is not trusted"
    assert len({delivery for delivery, _ in moved.attempts}) == 1
    for one in (flaky, secure, gone, moved):
        assert one.wrong == [], one.wrong
    log = console.log.read_text()
    assert "webhook gone (http://127.0.0.1:" in log and "answered 410" in log, log
    assert "delivers again after 2 failed attempts" in log, log
    for hidden in (SECRET, "secret-path"):
        assert hidden not in log and hidden not in console.ask("/metrics"), hidden


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    parser.add_argument("--resolver-shim", type=pathlib.Path,
                        help="library with a name that nobody resolves, for the console")
    given = parser.parse_args()
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    (given.folder / "secret").write_text(SECRET + "\n")
    (given.folder / "secret").chmod(0o600)
    check_refusals(given)
    port = free_port()
    process = check_documented(given, port)
    of_up = Receiver([200])
    (given.folder / "shop/up.textproto").write_text(
        receiver_text("of-up", of_up.url, 'events: "ended"').replace('"secret"', '"../secret"'))
    log = open(given.folder / "up.txt", "w")
    up = subprocess.Popen([given.bin / "intaglio", "up", "--folder", "shop", "--materials",
                           "materials.db", "--console", "--console-webhooks",
                           "shop/up.textproto", "--warm-up", "1", *PLACE],
                          cwd=given.folder, stdout=log, stderr=log)

    def is_open():
        assert up.poll() is None, (given.folder / "up.txt").read_text()
        return "the shop is open" in (given.folder / "up.txt").read_text()

    try:
        eventually(is_open, 120)
        process = check_deliveries(given, port, process)
        eventually(lambda: len(of_up.bodies()) == 2)
        assert {json.loads(body)["event"] for body in of_up.bodies()} == {"ended"}
    finally:
        process.kill()
        up.send_signal(signal.SIGINT)
        up.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
