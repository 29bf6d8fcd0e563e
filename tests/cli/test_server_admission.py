"""The server with more connections than it can have, and what it writes down."""
import json
import os
import re
import resource
import select
import shutil
import signal
import socket
import ssl
import stat
import subprocess
import sys
import time

import served
from harness import Skip, fails, main, sanitized, says, write_ball
from page import Page, Server, run
from wire import answer, attacked, behaves, codes, connect, ends, head, hello, one_answer, upgrade, wait_for

try:
    import websockets
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


def may_open(n):
    """As many files, of this program and of the server that it starts."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    assert most == resource.RLIM_INFINITY or most >= n, f"this system lets a program open {most} files"
    resource.setrlimit(resource.RLIMIT_NOFILE, (n, most))


# Connections --------------------------------------------------------------------------------------------------------

def test_a_thousand_slow_heads_keep_nobody_out():
    may_open(4000)
    with attacked() as server:
        slow = [connect(server) for _ in range(1000)]
        for sock in slow:
            sock.sendall(b"GET / HTTP/1.1\r\nHost: loc")
        run(behaves(server))
        for sock in slow[::10]:
            try:
                sock.sendall(b"a")
            except OSError:
                pass
        run(behaves(server))
        assert all(ends(sock) for sock in slow), "a head may take for ever"
        for sock in slow:
            sock.close()


def test_who_shows_no_token_keeps_nobody_out_by_connections():
    may_open(6000)
    with attacked() as server:
        strangers = [connect(server) for _ in range(3800)]
        for sock in strangers:
            try:
                sock.sendall(b"G")
            except OSError:  # it had to go for others
                pass
        assert [let_in(server) for _ in range(3)] == [204] * 3, "they keep the right token out"
        assert all(ends(sock) for sock in strangers[:3000]), "they stay"
        for sock in strangers:
            sock.close()


FLOOD = """
import socket, sys, time
held, n, end = [], 0, time.monotonic() + float(sys.argv[2])
while time.monotonic() < end:
    try:
        held.append(socket.create_connection(("127.0.0.1", int(sys.argv[1])), timeout=2))
        held[-1].sendall(b"GET / HTTP/1.1\\r\\nHo")
        n += 1
    except OSError:
        pass
    if len(held) > 800:
        held.pop(0).close()
print(n)
"""


def test_half_heads_as_many_as_one_can_send_make_nobody_wait_for_long():
    may_open(4000)
    with attacked() as server:
        looking = upgrade(server, server.cookie())[0]  # where nobody looks, connections may take all there is
        looking.sendall(hello())
        flood = subprocess.Popen([sys.executable, "-c", FLOOD, str(server.port), "10"], stdout=subprocess.PIPE)
        longest, n = 0, 0
        while flood.poll() is None:
            time.sleep(0.5)
            for step in (lambda: server.request("/")[0] == 200, lambda: let_in(server) == 204, lambda: run(sees(server))):
                began = time.monotonic()
                assert step(), "a newcomer is turned away"
                longest = max(longest, time.monotonic() - began)
            n += 1
        came = int(flood.communicate()[0])
        # with what they may cost at once, 2000 are enough to shut the doors; they came to wait for 5 to 20 s
        assert came > (500 if sanitized() else 3000) and n >= 2, (came, n)
        assert longest < (20 if sanitized() else 4), (longest, n, came)
        looking.close()


async def sees(server):
    async with Page(server, 64, 64) as page:
        await page.resting()
    return True


def let_in(server):
    return server.request("/session", json.dumps({"token": server.token}).encode())[0]


def few_files(n):
    """A program that may open n files and is VolVis else."""
    with open("few", "w", encoding="ascii") as file:
        file.write(f'#!/bin/sh\nulimit -n {n}\nexec "{os.path.abspath(served.VOLVIS)}" "$@"\n')
    os.chmod("few", 0o755)
    return os.path.abspath("few")


def test_when_there_are_too_many_connections_others_are_asked_to_come_again():
    whole = served.VOLVIS
    served.VOLVIS = few_files(200) # 100 connections
    try:
        write_ball("ball.nrrd", 16)
        server = Server("ball.nrrd")
    finally:
        served.VOLVIS = whole
    with server:
        cookie = server.cookie()
        idle = [upgrade(server, cookie)[0] for _ in range(90)]
        code, headers, body = server.request("/")
        assert code == 503 and int(headers["retry-after"]) > 0 and b"too many connections" in body, (code, body)
        assert server.request("/session", b"{}")[0] == 503
        more = [connect(server) for _ in range(60)]
        assert select.select(more, [], [], 60)[0], "there is no limit"
        assert server.process.poll() is None
        for sock in idle + more:
            sock.close()

        def is_let_in():
            try:
                return server.request("/")[0] == 200
            except OSError:  # closed at once
                return False
        wait_for(is_let_in, "there is room again when the others have gone")
        run(behaves(server))


def test_one_more_than_may_look_is_told_so():
    with attacked("--root", ".", "--clients", 2, verb="serve") as server:
        async def three():
            async with Page(server, 16, 16), Page(server, 16, 16):
                try:
                    async with Page(server, 16, 16):
                        raise AssertionError("three look where two may")
                except websockets.exceptions.ConnectionClosed as closed:
                    assert closed.code == 1013 and "2 people" in closed.reason, closed
        run(three())


# What is written down -----------------------------------------------------------------------------------------------

def test_the_audit_says_who_opened_what_and_nothing_anywhere_tells_a_secret():
    write_ball("other.nrrd", 8)
    name = "<img src=x onerror=alert(1)>\n.nrrd"
    write_ball(name, 8)
    os.makedirs("outside", exist_ok=True)
    secret = "a-token-that-nobody-knows-0123456789"
    with open("token", "w", encoding="ascii") as file:
        file.write(secret + "\n")
    os.chmod("token", 0o600)
    write_ball("ball.nrrd", 16)
    server = Server("ball.nrrd", "--root", ".", "--audit", "audit.jsonl", "--record", "record.txt", "--token-file", "token", "-v",
                    verb="serve")
    server.request("/session", json.dumps({"token": "x" * 30}).encode())
    cookie = server.cookie()

    async def work():
        async with Page(server, 64, 64) as one:
            await one.ask("open", path="other.nrrd")
            await one.ask("open", path=name)
            assert any(entry["name"] == name for entry in (await one.ask("browse", path=""))["entries"])
            assert await one.refused("open", path="/etc/passwd")
            assert await one.refused("edit", edits=[{"op": "set", "path": "datasets.x.path", "value": "/etc/shadow"}])
            await one.ask("save", path="scene.vv.json")
            await one.edit(("set", "title", "what people say is not written down"))
    run(work())
    assert server.request("/files/up.nrrd", b"abc", method="PUT", Cookie=cookie)[0] == 201
    code, said = server.end(signal.SIGINT)
    assert code in (0, 130), said

    with open("audit.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    assert all(stat.S_IMODE(os.stat(name).st_mode) == 0o600 for name in ("audit.jsonl", "record.txt"))
    assert all(line["address"] == "127.0.0.1" and re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", line["time"]) for line in lines)
    told = [(line["what"], line.get("object"), line.get("refused", False)) for line in lines]
    for expected in (("token", None, True), ("token", None, False), ("comes", None, False), ("open", "other.nrrd", False),
                     ("open", name, False), ("open", "/etc/passwd", True), ("edit", "/etc/shadow", True),
                     ("save", "scene.vv.json", False), ("upload", "up.nrrd", False), ("leaves", None, False)):
        assert expected in told, (expected, told)
    assert len({line["client"] for line in lines if "client" in line}) == 1

    written = {"stderr": said}
    for folder, _, names in os.walk("."):
        for one in names:
            path = os.path.join(folder, one)
            if one != "token" and os.path.getsize(path) < 1 << 20:
                with open(path, encoding="latin-1") as file:
                    written[path] = file.read()
    for path, text in written.items():
        assert secret not in text and cookie.split("=")[1] not in text and "x" * 30 not in text, path
    assert "what people say" not in written["./audit.jsonl"]


def test_an_audit_that_cannot_be_written_is_told_at_once():
    write_ball("ball.nrrd", 8)
    says(fails(5, "serve", "ball.nrrd", "--root", ".", "--audit", "/proc/nothing/audit"), "/proc/nothing/audit")


def test_an_audit_goes_to_pipes_and_devices_and_to_the_programs_own_output():
    write_ball("ball.nrrd", 8)
    os.mkfifo("pipe")
    says(fails(5, "serve", "ball.nrrd", "--audit", "pipe"), "pipe: ", "a pipe that nobody reads")
    reader = os.open("pipe", os.O_RDONLY | os.O_NONBLOCK)
    with Server("ball.nrrd", "--audit", "pipe", verb="serve") as server:
        server.request("/session", json.dumps({"token": "x" * 30}).encode())
        wait_for(lambda: select.select([reader], [], [], 0)[0], "nothing was written to the pipe")
        assert json.loads(os.read(reader, 4096).splitlines()[0])["what"] == "token"
    os.close(reader)
    for name in ("/dev/stderr", "/dev/null"):
        with Server("ball.nrrd", "--audit", name, verb="serve") as server:
            server.request("/session", json.dumps({"token": "x" * 30}).encode())
            _, said = server.end(signal.SIGTERM)
        assert ("\"what\"" in said) == (name == "/dev/stderr"), said


def test_a_name_of_a_file_is_never_part_of_a_page():
    name = "%3Cscript%3Ealert(1)%3C%2Fscript%3E"
    with attacked() as server:
        cookie = server.cookie()
        for path in (f"/{name}", f"/files/{name}", f"/files/1/{name}", f"/?{name}", f"/<script>alert(1)</script>"):
            got = answer(server, head(server, f"GET {path} HTTP/1.1", "Connection: close", cookie=cookie))
            parts = got.split(b"\r\n\r\n", 1)
            assert codes(got)[:1] != [302] and b"location:" not in parts[0].lower()
            assert b"alert(1)" not in got, got
            if codes(got)[:1] != [200]:
                assert b"text/html" not in parts[0].lower(), got
        got = answer(server, head(server, "PUT /files/%3Cimg%20src=x%20onerror=alert(1)%3E HTTP/1.1", "Content-Length: 1",
                                  cookie=cookie) + b"x")
        assert b"application/json" in got or 400 in codes(got), got


# Secrets ------------------------------------------------------------------------------------------------------------

def test_a_token_that_others_may_read_or_guess_is_refused():
    write_ball("ball.nrrd", 8)
    with open("open", "w", encoding="ascii") as file:
        file.write("a-token-that-nobody-knows-0123456789")
    for mode in (0o644, 0o640, 0o604, 0o620):
        os.chmod("open", mode)
        says(fails(2, "serve", "ball.nrrd", "--token-file", "open"), "others may read it", "chmod 600")
    if os.geteuid() == 0:
        os.chmod("open", 0o600)
        os.chown("open", 1234, 1234)
        says(fails(2, "serve", "ball.nrrd", "--token-file", "open"), "belongs to another user (number 1234)", "chown 0 open")
    for token in ("aaaaaaaaaaaaaaaa", "1234567890" * 3, "abababababababab", "password" * 4, "0123456789abcdef"):
        says(fails(2, "serve", "ball.nrrd", "--token", token), "can be guessed")
    says(fails(2, "serve", "ball.nrrd", "--token", "b7f09c2ae5d1836f"), "16 characters of its kind have 64 bits", "128 or more")


def test_an_audit_file_that_was_there_is_closed_to_others():
    write_ball("ball.nrrd", 8)
    for before, after in ((0o644, 0o640), (0o666, 0o660), (0o600, 0o600)):
        with open("there.jsonl", "w", encoding="ascii"):
            pass
        os.chmod("there.jsonl", before)
        with Server("ball.nrrd", "--audit", "there.jsonl"):
            assert stat.S_IMODE(os.stat("there.jsonl").st_mode) == after


def test_what_is_written_down_goes_into_no_file_that_was_there_and_through_no_link():
    write_ball("ball.nrrd", 8)
    with open("mine", "w", encoding="ascii") as file:
        file.write("mine")
    for link, target in (("dangling", "made"), ("link", "mine")):
        os.symlink(target, link)
        says(fails(5, "serve", "ball.nrrd", "--audit", link), link, "symbolic link")
        says(fails(5, "serve", "ball.nrrd", "--record", link), link, "there is such a file")
    says(fails(5, "serve", "ball.nrrd", "--record", "mine"), "mine", "remove it or give another name")
    assert not os.path.lexists("made")
    with open("mine", encoding="ascii") as file:
        assert file.read() == "mine"


def test_a_token_of_the_command_line_is_not_in_the_list_of_programs():
    write_ball("ball.nrrd", 8)
    token = "a-token-that-nobody-knows-0123456789"
    for words in (("--token", token), (f"--token={token}",)):
        with Server("ball.nrrd", *words, verb="serve") as server:
            with open(f"/proc/{server.process.pid}/cmdline", "rb") as cmdline:
                assert token.encode() not in cmdline.read()
            assert server.token == token
            server.cookie()


def browser_that_notes(folder="bin"):
    """xdg-open in the place of the system's: it writes down what it was given."""
    os.makedirs(folder)
    with open(f"{folder}/xdg-open", "w", encoding="ascii") as file:
        file.write('#!/bin/sh\necho "$@" > argv.new; stat -c %a "$1" > mode; cat "$1" > page; mv argv.new argv\n')
    os.chmod(f"{folder}/xdg-open", 0o755)
    return f"{os.path.abspath(folder)}:{os.environ['PATH']}"


def test_the_browser_is_given_a_file_whose_link_lets_in_once_and_no_list_of_programs_tells_it():
    write_ball("ball.nrrd", 8)
    before = {name: os.environ.get(name) for name in ("PATH", "DISPLAY")}
    os.environ.update(PATH=browser_that_notes(), DISPLAY=":0")
    os.makedirs("state/volvis", mode=0o700)
    of_killed, of_others = f"state/volvis/open-{'0' * 16}.html", f"state/volvis/open-{'1' * 16}.html"
    for path, age in ((of_killed, 7200), (of_others, 60)):
        with open(path, "w", encoding="ascii"):
            os.utime(path, (time.time() - age,) * 2)
    try:
        with Server("ball.nrrd", verb="view", browser=True) as server:
            wait_for(lambda: os.path.exists("argv"), "a browser is started")
            with open("argv", encoding="utf-8") as argv, open("page", encoding="utf-8") as text, open("mode", encoding="ascii") as mode:
                words, link, mode = argv.read().strip(), text.read(), mode.read().strip()
            launch = re.search(r"url=(http://localhost:\d+)/#([0-9a-f]{64})", link)
            assert mode == "600" and launch[2] not in words and server.token not in words + link, (mode, words, link)
            with open(f"/proc/{server.process.pid}/cmdline", "rb") as cmdline:
                assert server.token.encode() not in cmdline.read()
            assert os.path.exists(words) and os.path.exists(of_others)
            assert not os.path.exists(of_killed), "what a killed program has left stays"
            assert server.request("/files/1/x", Authorization=f"Bearer {launch[2]}")[0] == 403, "the link is a token"
            server.cookie(launch[2])
            assert not os.path.exists(words), "the file stays"
            assert server.request("/session", json.dumps({"token": launch[2]}).encode())[0] == 403, "it lets in twice"
            server.cookie()
    finally:
        os.environ.update({name: value for name, value in before.items() if value is not None})
        if before["DISPLAY"] is None:
            del os.environ["DISPLAY"]


def test_all_sessions_are_ended_from_a_page_and_the_program_prints_another_link():
    with attacked() as server:
        cookie = server.cookie()
        sock, got = upgrade(server, cookie)
        assert b" 101 " in got
        code, headers, _ = server.request("/session", method="DELETE", Cookie=cookie, Origin=server.base)
        assert code == 204 and ends(sock)
        fresh = headers["set-cookie"].split(";")[0]
        link = json.loads(server.process.stdout.readline())["link"]
        assert link.startswith(server.base) and not link.endswith(server.token)
        assert server.request("/session", json.dumps({"token": server.token}).encode())[0] == 403
        for one, fine in ((cookie, False), (fresh, True)):
            sock, got = upgrade(server, one)
            assert (b" 101 " in got) == fine
            sock.close()
        server.token = link.split("#")[1]


def test_who_may_only_look_does_not_send_others_away():
    write_ball("ball.nrrd", 8)
    with Server("ball.nrrd", "--read-only", verb="serve") as server:
        cookie = server.cookie()
        sock, got = upgrade(server, cookie)
        assert b" 101 " in got
        code, headers, said = server.request("/session", method="DELETE", Cookie=cookie, Origin=server.base)
        assert code == 403 and b"read-only" in said and "set-cookie" not in headers, (code, said)
        again, got = upgrade(server, cookie)
        assert b" 101 " in got
        for one in (sock, again):
            one.close()


def test_without_a_home_a_session_is_kept_where_nobody_else_can_put_it():
    write_ball("ball.nrrd", 8)
    nobody = {"HOME": "", "XDG_STATE_HOME": ""}
    place = f"/tmp/volvis-{os.getuid()}"
    if os.path.lexists(place):
        raise Skip(f"{place} is there: a program without a home runs")
    try:
        os.symlink(os.path.abspath("."), place)
        says(fails(5, "replay", "nothing.jsonl", env=nobody), place, "HOME")
        os.remove(place)
        os.mkdir(place, 0o755)
        says(fails(5, "replay", "nothing.jsonl", env=nobody), place, "HOME")
        os.rmdir(place)
        fails(3, "replay", "nothing.jsonl", env=nobody)
        assert stat.S_IMODE(os.stat(place).st_mode) == 0o700
    finally:
        if os.path.islink(place):
            os.remove(place)
        elif os.path.isdir(place) and not os.listdir(place):
            os.rmdir(place)


# Addresses ----------------------------------------------------------------------------------------------------------

def refuses(what, *words):
    try:
        what(*words)
        return False
    except OSError:
        return True


def test_both_loopback_addresses_are_the_servers_or_the_link_says_which():
    with attacked() as server:
        try:
            sock = socket.create_connection(("::1", server.port), timeout=60)
        except OSError:
            assert "//127.0.0.1:" in server.base, "somebody else may be there under this name"
            raise Skip("this machine has no IPv6")
        with sock:
            sock.sendall(f"GET / HTTP/1.1\r\nHost: [::1]:{server.port}\r\n\r\n".encode())
            assert codes(one_answer(sock)) == [200] and "//localhost:" in server.base
    for address, base in (("::1", "http://[::1]:"), ("127.0.0.1", "http://127.0.0.1:"), ("0.0.0.0", "http://localhost:")):
        with Server("ball.nrrd", "--listen", address, verb="serve") as server:
            assert server.base == f"{base}{server.port}", server.base
            with socket.create_connection(("::1" if address == "::1" else "127.0.0.1", server.port), timeout=60) as sock:
                sock.sendall(f"GET / HTTP/1.1\r\nHost: {server.base[7:]}\r\n\r\n".encode())
                assert codes(one_answer(sock)) == [200]
            if "localhost" in base:
                with socket.socket(socket.AF_INET6) as other:
                    assert refuses(other.bind, ("::1", server.port)), "another program can be localhost"
    with socket.socket(socket.AF_INET6) as other:
        other.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        other.bind(("::1", 0))
        other.listen()
        port = other.getsockname()[1]
        for words, verb in (((), "view"), (("--listen", "0.0.0.0"), "serve")):
            try:
                server = Server("ball.nrrd", "--port", port, *words, verb=verb)
            except AssertionError:
                raise Skip("another program has this port")
            with server:
                assert server.base == f"http://127.0.0.1:{port}", "the link leads to somebody else"


def test_only_numbers_of_this_machine_are_listened_on_and_the_one_that_was_used_is_a_host():
    write_ball("ball.nrrd", 16)
    for address, part in (("localhost", "none"), ("nonsense", "none"), ("[::1]", "none"), ("10.9.9.9", "not an address of this machine")):
        says(fails(2, "serve", "ball.nrrd", "--listen", address), part)
    with Server("ball.nrrd", "--listen", "0.0.0.0", verb="serve") as server:
        for used, host, code in (("127.0.0.2", "127.0.0.2", 200), ("127.0.0.2", "127.0.0.3", 403), ("127.0.0.1", "127.0.0.2", 403),
                                 ("127.0.0.2", "evil.example", 403), ("127.0.0.2", "localhost", 200)):
            for origin in (host, "6.6.6.6"):
                with socket.create_connection((used, server.port), timeout=60) as sock:
                    sock.sendall(f"GET / HTTP/1.1\r\nHost: {host}:{server.port}\r\nOrigin: http://{origin}:{server.port}\r\n\r\n".encode())
                    assert codes(one_answer(sock)) == [code if origin == host else 403], (used, host, origin)


# TLS ----------------------------------------------------------------------------------------------------------------

def make_certificate(key, certificate, *words, new="rsa:2048"):
    subprocess.run(["openssl", "req", "-x509", "-newkey", new, *(words or ["-nodes"]), "-keyout", key, "-out", certificate, "-days", "2",
                    "-subj", "/CN=localhost"], check=True, capture_output=True)


def test_a_certificate_or_key_that_cannot_be_used_is_told_before_a_port_is_opened():
    if not shutil.which("openssl"):
        raise Skip("openssl is missing: no certificate to serve with")
    write_ball("ball.nrrd", 8)
    make_certificate("key.pem", "cert.pem")
    make_certificate("key2.pem", "cert2.pem")
    make_certificate("curve-key.pem", "curve.pem", "-nodes", "-pkeyopt", "ec_paramgen_curve:prime256v1", new="ec")
    make_certificate("short-key.pem", "short.pem", new="rsa:1024")
    make_certificate("locked.pem", "locked-cert.pem", "-passout", "pass:secret")
    for name, text in (("garbage.pem", "x"), ("empty.pem", "")):
        with open(name, "w", encoding="ascii") as file:
            file.write(text)
    for names, sentence in ((("garbage.pem", None), "garbage.pem: holds no certificate"), (("empty.pem", None), "empty.pem: holds no certificate"),
                            (("cert.pem", None), "cert.pem: holds no key"), (("cert.pem", "garbage.pem"), "garbage.pem: holds no key"),
                            (("cert.pem", "key2.pem"), "key2.pem: is not the key of the certificate cert.pem"),
                            (("cert.pem", "curve-key.pem"), "curve-key.pem: is not the key of the certificate cert.pem"),
                            (("short.pem", "short-key.pem"), "short.pem: the certificate has a key that is too short"),
                            (("locked-cert.pem", "locked.pem"), "locked.pem: the key has a password")):
        words = ["--tls-cert", names[0], *(["--tls-key", names[1]] if names[1] else [])]
        for more in ((), ("--dry-run",)):
            said = fails(2, "serve", "ball.nrrd", *words, *more)
            assert sentence in said and "port" not in said, said
    says(fails(2, "serve", "ball.nrrd", "--tls-key", "key.pem"), "key.pem", "without its certificate", "--tls-cert")
    with open("both.pem", "w", encoding="ascii") as both:
        for name in ("cert.pem", "key.pem"):
            with open(name, encoding="ascii") as file:
                both.write(file.read())
    for name, words in (("key.pem", ("--tls-cert", "cert.pem", "--tls-key", "key.pem")), ("both.pem", ("--tls-cert", "both.pem"))):
        for mode in (0o644, 0o604, 0o641, 0o660):
            os.chmod(name, mode)
            says(fails(2, "serve", "ball.nrrd", *words), "others may read it", f"chmod 600 {name}")
        for mode in (0o640, 0o600):  # Debian's own are root's, 0640, for a group of servers
            os.chmod(name, mode)
            with Server("ball.nrrd", *words, verb="serve") as server:
                assert server.base.startswith("https://")
    if os.geteuid() == 0:
        os.chmod("key.pem", 0o640)
        os.chown("key.pem", 65534, -1)
        says(fails(2, "serve", "ball.nrrd", "--tls-cert", "cert.pem", "--tls-key", "key.pem"), "others may read it")


def test_tls_is_1_2_with_ephemeral_keys_or_1_3_and_names_that_are_not_loopback_are_told_to_stay_with_it():
    if not shutil.which("openssl"):
        raise Skip("openssl is missing: no certificate to serve with")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", "key.pem", "-out", "cert.pem",
                    "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,DNS:viewer.example"],
                   check=True, capture_output=True)
    write_ball("ball.nrrd", 8)

    def talk(server, name="localhost", **changes):
        context = ssl.create_default_context(cafile="cert.pem")
        context.set_ciphers(changes.get("ciphers", "ALL:@SECLEVEL=0"))
        context.minimum_version, context.maximum_version = changes.get("versions", (ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_3))
        with connect(server) as sock, context.wrap_socket(sock, server_hostname=name) as tls:
            tls.sendall(f"GET / HTTP/1.1\r\nHost: {name}:{server.port}\r\n\r\n".encode())
            return tls.version(), one_answer(tls)
    two, three = ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3
    with Server("ball.nrrd", "--tls-cert", "cert.pem", "--tls-key", "key.pem", "--host-name", "viewer.example", verb="serve") as server:
        assert talk(server)[0] == "TLSv1.3" and b"strict-transport" not in talk(server)[1]
        assert b"strict-transport-security: max-age=" in talk(server, "viewer.example")[1]
        assert talk(server, versions=(two, two), ciphers="ECDHE-RSA-AES128-GCM-SHA256")[0] == "TLSv1.2"
        assert talk(server, versions=(three, three))[0] == "TLSv1.3"
        for changes in ({"versions": (ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1)}, {"versions": (two, two), "ciphers": "AES128-SHA:@SECLEVEL=0"},
                        {"versions": (two, two), "ciphers": "AES128-GCM-SHA256"}, {"versions": (two, two), "ciphers": "ECDHE-RSA-AES128-SHA256"}):
            try:
                raise AssertionError(f"{changes}: {talk(server, **changes)}")
            except (ssl.SSLError, ConnectionError):
                pass


if __name__ == "__main__":
    main()
