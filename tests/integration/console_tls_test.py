#!/usr/bin/python3
"""A console that serves a network: encrypted, with a log-in and an identity, or not at all.

  console_tls_test.py --bin FOLDER_OF_PROGRAMS --folder FOLDER
"""
import argparse
import base64
import http.client
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
import time

from patience import eventually

PASSWORD = "correct horse"


def make_certificate(folder):
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                    "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", "/CN=shop",
                    "-addext", "subjectAltName=DNS:shop.test,IP:127.0.0.1", "-keyout",
                    folder / "key.pem", "-out", folder / "certificate.pem"],
                   check=True, capture_output=True)


class Client:
    """Requests of somebody who trusts the certificate."""

    def __init__(self, folder, port):
        self.port = port
        self.context = ssl.create_default_context(cafile=folder / "certificate.pem")
        self.cookie = None

    def ask(self, method, path, body=None, headers=None, host=None):
        connection = http.client.HTTPSConnection("127.0.0.1", self.port, context=self.context,
                                                 timeout=20)
        given = {"Host": host or f"shop.test:{self.port}", **(headers or {})}
        if self.cookie:
            given["Cookie"] = self.cookie
        connection.request(method, path, body, given)
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        return answer.status, text, answer.headers

    def log_in(self):
        status, text, headers = self.ask("POST", "/api/v1/login", json.dumps(
            {"name": "anna", "password": PASSWORD}))
        assert status == 200, (status, text)
        cookie = headers["Set-Cookie"]
        assert re.fullmatch(r"intaglio_\d+=[0-9a-f]{64}; Path=/; HttpOnly; SameSite=Strict; Secure",
                            cookie), cookie
        self.cookie = cookie.split(";")[0]

    def first_state(self, origin):
        """The first text of the WebSocket /control; None when it is refused."""
        with socket.create_connection(("127.0.0.1", self.port), 20) as plain, \
                self.context.wrap_socket(plain, server_hostname="shop.test") as line:
            key = base64.b64encode(os.urandom(16)).decode()
            line.sendall((f"GET /control HTTP/1.1\r\nHost: shop.test:{self.port}\r\n"
                          f"Origin: {origin}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                          f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"
                          f"Cookie: {self.cookie}\r\n\r\n").encode())
            head = line.recv(65536)
            if b" 101 " not in head:
                return None
            got = head.split(b"\r\n\r\n", 1)[1]
            while b'"shop"' not in got:
                more = line.recv(65536)
                assert more, got
                got += more
            return got


def refused(program, words, remedy):
    """Ends with 2 and names the remedy."""
    done = subprocess.run([program, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and remedy in done.stderr, (done.returncode, done.stderr)


def check(folder, port):
    client = Client(folder, port)
    assert client.ask("GET", "/")[0] == 200
    assert client.ask("GET", "/api/v1/status")[0] == 401
    assert client.ask("GET", "/", host="evil.example")[0] == 421
    client.log_in()
    assert client.ask("GET", "/api/v1/session")[0] == 200
    own = f"https://shop.test:{port}"

    def announced():
        services = json.loads(client.ask("GET", "/api/v1/status")[1])["services"]
        return any(one["role"] == "console" and one["message"] == own for one in services)

    eventually(announced, 60)  # by its identity, to other consoles of the shop
    stop = ("POST", "/api/v1/stop", "{}")
    assert client.ask(*stop, {"Origin": f"http://shop.test:{port}"})[0] == 403
    assert client.ask(*stop, {"Origin": "https://evil.example"})[0] == 403
    assert client.ask(*stop, {"Origin": own})[0] == 200
    assert client.first_state("https://evil.example") is None
    assert client.first_state(own)
    # Nothing is answered that is not encrypted, or by an old protocol.
    with socket.create_connection(("127.0.0.1", port), 20) as plain:
        plain.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        try:
            answer = plain.recv(4096)
        except ConnectionResetError:
            answer = b""
        assert b"HTTP" not in answer, answer
    old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
    old.set_ciphers("ALL:@SECLEVEL=0")
    old.minimum_version = old.maximum_version = ssl.TLSVersion.TLSv1_1
    with socket.create_connection(("127.0.0.1", port), 20) as plain:
        try:
            old.wrap_socket(plain)
            raise AssertionError("TLS 1.1 is answered")
        except ssl.SSLError as error:
            assert "ALERT_PROTOCOL_VERSION" in str(error), error
    # Half-open handshakes keep nobody out.
    half_open = []
    for _ in range(300):
        half_open.append(socket.create_connection(("127.0.0.1", port), 20))
    assert client.ask("GET", "/api/v1/status")[0] == 200
    for connection in half_open:
        connection.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    given = parser.parse_args()
    folder = given.folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    make_certificate(folder)
    intaglio, program = given.bin / "intaglio", given.bin / "intaglio-console"
    users = folder / "users"
    subprocess.run([intaglio, "security", "new", folder / "keys", "--domain", "48"], check=True,
                   capture_output=True)
    bus = ["--domain", "48", "--tag", f"tls{os.getpid()}"]
    network = ["--address", "0.0.0.0", *bus]
    certificate = ["--certificate", folder / "certificate.pem",
                   "--private-key", folder / "key.pem"]
    identity = ["--security", folder / "keys"]
    log_in = ["--users", users]
    refused(program, [*network, *log_in, *identity], "user add")
    subprocess.run([intaglio, "console", "user", "add", "anna", "--role", "operator", "--users",
                    users], input=PASSWORD + "\n", text=True, check=True)
    refused(program, [*network, *log_in, *identity], "--certificate")
    refused(program, [*network, *log_in, *certificate], "--security")
    refused(program, [*network, *log_in, *identity, "--certificate", folder / "key.pem",
                      "--private-key", folder / "key.pem"], "as the certificate")
    log = open(folder / "console.txt", "w")
    console = subprocess.Popen([program, *network, *log_in, *certificate, *identity],
                               stdout=log, stderr=log)
    try:
        end = time.monotonic() + 40
        while time.monotonic() < end:
            found = re.search(r"https://shop\.test:(\d+)/\s", (folder / "console.txt").read_text())
            if found:
                break
            time.sleep(0.1)
        assert found, (folder / "console.txt").read_text()
        check(folder, int(found[1]))
    finally:
        console.send_signal(signal.SIGINT)
        console.wait(20)
    return 0


if __name__ == "__main__":
    sys.exit(main())
