"""Attacks by heads of requests: all that can be spelled in more than one way, or names somebody else."""
import json
import random

from attack import Attack, short
from wire import head

NO = (400, 403)
BAD = (400,)
NOT_HERE = (400, 403, 404)


def raw(*lines):
    return b"\r\n".join(line.encode("latin-1") if isinstance(line, str) else line for line in lines) + b"\r\n\r\n"


def hosts(server):
    p = server.port
    for host in (f"evil.example:{p}", f"localhost.evil.example:{p}", f"127.0.0.1.evil.example:{p}", f"evil.example#localhost:{p}",
                 f"localhost:{p}@evil.example", f"localhost:{p}.evil.example", f"127.1:{p}", f"0.0.0.0:{p}", f"2130706433:{p}",
                 f"0x7f000001:{p}", f"localhost.:{p}", "localhost:0", "localhost", f"localhost:{p + 1}", f"localhost:0{p}",
                 f"localhost:{p}, evil.example", "", f"[::]:{p}", f"[::2]:{p}", f"[::ffff:127.0.0.1]:{p}", f"::1:{p}", f"localhost:{p}/",
                 f"localhost:{p}\\evil", f" localhost:{p} x", f"localhost :{p}", f"http://localhost:{p}", f"local\xadhost:{p}",
                 f"LOCALHOST.EXAMPLE:{p}", "a" * 300, "a" * 9000, f"localhost:{p}" + "0" * 20, f"localhost:{p}\x00"):
        yield Attack(f"Host {short(host)}", raw("GET / HTTP/1.1", f"Host: {host}"), (400, 403, 431))
    for first in ("GET / HTTP/1.1", "POST /session HTTP/1.1", "GET /ws HTTP/1.1"):
        yield Attack(f"{first} without Host", raw(first), BAD)
    yield Attack("two Hosts", raw("GET / HTTP/1.1", f"Host: localhost:{p}", "Host: evil.example"), BAD)
    yield Attack("two Hosts, the other way round", raw("GET / HTTP/1.1", "Host: evil.example", f"Host: localhost:{p}"), BAD)
    yield Attack("Host in the target", raw(f"GET http://localhost:{p}/ HTTP/1.1", "Host: evil.example"), NO)


def foreign_origins(server):
    p = server.port
    return ["http://evil.example", "null", "", f"https://localhost:{p}", f"http://localhost:{p}.evil.example", f"http://localhost:{p + 1}",
            f"ws://localhost:{p}", f"HTTP://localhost:{p}", f"http://localhost:{p}/", f"http://localhost:{p}@evil", "http://localhost",
            f"http:/localhost:{p}", f"http://x@localhost:{p}", f"http://localhost:{p} http://evil", f"file://localhost:{p}",
            f"http://127.0.0.2:{p}", "a" * 310, "a" * 8000, f"http://[::1%lo]:{p}"]


def origins(server):
    for origin in foreign_origins(server):
        yield Attack(f"Origin {short(origin)}", head(server, "GET / HTTP/1.1", f"Origin: {origin}"), NO)
        yield Attack(f"token with Origin {short(origin)}",
                     head(server, "GET /files/1/x HTTP/1.1", f"Origin: {origin}", f"Authorization: Bearer {server.token}"), NO)
    for site in ("cross-site", "same-site", "", "same-origin, cross-site", "SAME-ORIGIN", "x" * 9000):
        yield Attack(f"Sec-Fetch-Site {short(site)}", head(server, "GET / HTTP/1.1", f"Sec-Fetch-Site: {site}"), (400, 403, 431))
    link = ("Sec-Fetch-Site: cross-site", "Sec-Fetch-Mode: navigate", "Sec-Fetch-Dest: document")
    yield Attack("a link that is followed shows the empty page", head(server, "GET / HTTP/1.1", *link), (200,))
    for first in ("GET /app.js", "GET /files/1/x", "POST /", "PUT /files/link", "DELETE /session", "GET /ws", "GET //"):
        yield Attack(f"a link to {first}", head(server, f"{first} HTTP/1.1", *link, "Content-Length: 0", cookie=server.own_cookie), NO)
    for mode, dest in (("navigate", "iframe"), ("navigate", "embed"), ("no-cors", "document"), ("cors", "empty"), ("no-cors", "image"),
                       ("navigate", ""), ("nested-navigate", "document"), ("websocket", "websocket")):
        yield Attack(f"cross-site {mode} {dest}", head(server, "GET / HTTP/1.1", "Sec-Fetch-Site: cross-site", f"Sec-Fetch-Mode: {mode}",
                                                       f"Sec-Fetch-Dest: {dest}", cookie=server.own_cookie), NO)


LENGTHS = ("+0", "-0", "0x0", "0x10", "0, 0", "0,0", "", "1e1", "0 0", "00000000000000000000", "0;", "0\t0", '"0"', "5, 6", "-1",
           "99999999999999999999", "x", "0_0", "0.0", "+5", "\xb2", "5a", "a5", "0\x0b", "9223372036854775808", "18446744073709551616", "\x000")


def lengths(server):
    cookie = server.own_cookie
    for length in LENGTHS:
        for first, more in (("GET /nothing", None), ("POST /session", None), ("PUT /files/length", cookie)):
            yield Attack(f"{first} with Content-Length {short(length)}",
                         head(server, f"{first} HTTP/1.1", f"Content-Length: {length}", cookie=more) + b"{}", BAD)
    for one, two in ((0, 500), (2, 0), (5, 5), (5, 6), ("", 2)):
        for first in ("GET /nothing", "POST /session", "PUT /files/length"):
            yield Attack(f"{first} with lengths {one} and {two}", head(
                server, f"{first} HTTP/1.1", f"Content-Length: {one}", f"content-length: {two}", cookie=cookie) + b"{}", BAD)
    yield Attack("a body of 5000 bytes for a token", head(server, "POST /session HTTP/1.1", "Content-Length: 5000") + b"x" * 5000, (413,))
    yield Attack("no length", head(server, "POST /session HTTP/1.1") + b"{}", (411,))
    for word in ("101-continue", "100-continue, x", "", "x" * 300):
        yield Attack(f"Expect {short(word)}", head(server, "PUT /files/expect HTTP/1.1", "Content-Length: 9", f"Expect: {word}", cookie=cookie), (417,))
    yield Attack("an upload without length", head(server, "PUT /files/x HTTP/1.1", cookie=cookie), (411,))
    yield Attack("something with GET", head(server, "GET / HTTP/1.1", "Content-Length: 2") + b"{}", BAD)


def codings(server):
    cookie, hidden = server.own_cookie, head(server, "GET /app.js HTTP/1.1")
    rows = [[f"Transfer-Encoding: {coding}"] for coding in ("chunked", "Chunked", "xchunked", "identity", "chunked, identity", "\tchunked",
                                                            "gzip, chunked", "", "chunked;x", "\x0bchunked", "\"chunked\"")]
    rows += [["Transfer-Encoding : chunked"], ["Transfer-Encoding\t: chunked"], [" Transfer-Encoding: chunked"],
             ["Transfer-Encoding:\r\n chunked"], ["X: y\r\n Transfer-Encoding: chunked"], ["X\r\nTransfer-Encoding: chunked"],
             ["Transfer-Encoding: identity", "Transfer-Encoding: chunked"], ["Transfer-Encoding\x00: chunked"],
             ["X: y\nTransfer-Encoding: chunked"], ["X: y\rTransfer-Encoding: chunked"]]
    for row in rows:
        for length in ([], ["Content-Length: 5"]):
            for first in ("POST /session", "PUT /files/coding"):
                yield Attack(f"{first} with {short(', '.join(row + length))}",
                             head(server, f"{first} HTTP/1.1", *length, *row, cookie=cookie) + b"0\r\n\r\n" + hidden, (400, 411))


def targets(server):
    for c in [*range(1, 10), *range(11, 13), *range(14, 33), 127, 128, 255]:
        yield Attack(f"byte {c} in a target", raw(b"GET /a" + bytes([c]) + b"b HTTP/1.1", f"Host: localhost:{server.port}"), BAD)
    for c in [*range(32), 127]:
        yield Attack(f"%{c:02x} in a target", head(server, f"GET /a%{c:02x}b HTTP/1.1"), BAD)
    for target in ("%", "/%", "/%g1", "/%1", "/%%41", "/%u0041", "/%ff", "/%c0%ae", "/%ed%a0%80", "/%f4%90%80%80", "*", "http://evil.example/",
                   "evil.example:443", "\\", "", "/#x", "x", "/\xe4", "?", "/a b"):
        yield Attack(f"target {short(target)}", head(server, f"GET {target} HTTP/1.1"), (*BAD, 505))
    for target in ("//", "//evil.example/", "/.", "/..", "/index.html/", "/app.js%20", "/APP.JS", "/app.js;x", "/files", "/session/", "/%2f"):
        yield Attack(f"target {short(target)}", head(server, f"GET {target} HTTP/1.1"), NOT_HERE)
    token = server.token
    for place in (f"/files/1/x?token={token}", f"/files/1/x?{token}", f"/files/{token}/x", f"/session?token={token}"):
        yield Attack(f"the token in {place[:20]}", head(server, f"GET {place} HTTP/1.1"), NOT_HERE)


def ways_out(server):
    spellings = ("..", "%2e%2e", "%2E%2e", ".%2e", "..%00", "%252e%252e", "..%5c..", "..\\..", "%c0%ae%c0%ae", "%u002e%u002e", "....//", "..;",
                 "..%2f..", "%2f..", "%uff0e%uff0e")
    for spelling in spellings:
        for start in ("/", "/files/", "/files/1/", "/app.js/"):
            for target in ("/etc/passwd", "%2fetc%2fpasswd"):
                path = f"{start}{'/'.join([spelling] * 8)}{target}"
                yield Attack(f"GET {short(path)}", head(server, f"GET {path} HTTP/1.1", cookie=server.own_cookie), NOT_HERE)


def methods(server):
    for method in ("DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "HEAD", "POST", "PUT", "BREW", "get", "G", "PROPFIND", "GET\x00", "(GET)"):
        for path in ("/", "/nothing", "/files/1/x", "*"):
            yield Attack(f"{short(method)} {path}", head(server, f"{method} {path} HTTP/1.1", "Content-Length: 0"), (400, 403, 405))
    for version in ("HTTP/1.0", "HTTP/1.2", "HTTP/2.0", "HTTP/2", "HTTP/9.9", "HTTP/1.1 x", "http/1.1", "HTTP/01.1", "HTTP/1.1.1", "HTTP/", "X/1.1",
                    "", "HTTP/1.1\t"):
        yield Attack(f"version {short(version)}", head(server, f"GET / {version}"), (400, 505))
    yield Attack("end all sessions without a cookie", head(server, "DELETE /session HTTP/1.1"), (403,))


def lines(server):
    host = f"Host: localhost:{server.port}".encode()
    for name, data in (("LF alone", b"GET / HTTP/1.1\n" + host + b"\n\n"), ("CR alone", b"GET / HTTP/1.1\r" + host + b"\r\r\n\r\n"),
                       ("CR CR LF", b"GET / HTTP/1.1\r\r\n" + host + b"\r\n\r\n"), ("an empty line first", b"\r\nGET / HTTP/1.1\r\n" + host + b"\r\n\r\n"),
                       ("a blank first", b" GET / HTTP/1.1\r\n" + host + b"\r\n\r\n"), ("two blanks", b"GET  / HTTP/1.1\r\n" + host + b"\r\n\r\n"),
                       ("a tab", b"GET\t/\tHTTP/1.1\r\n" + host + b"\r\n\r\n"), ("no target", b"GET HTTP/1.1\r\n" + host + b"\r\n\r\n"),
                       ("no version", b"GET /\r\n\r\n"), ("a word", b"GET\r\n\r\n"), ("a NUL in a value", b"GET / HTTP/1.1\r\n" + host + b"\r\nX: a\0b\r\n\r\n"),
                       ("a header that goes on", b"GET / HTTP/1.1\r\n" + host + b"\r\nX: a\r\n b\r\n\r\n"),
                       ("a header that goes on by a tab", b"GET / HTTP/1.1\r\n" + host + b"\r\nX: a\r\n\tb\r\n\r\n"),
                       ("a header that begins so", b"GET / HTTP/1.1\r\n X: a\r\n" + host + b"\r\n\r\n"),
                       ("no colon", b"GET / HTTP/1.1\r\n" + host + b"\r\nX\r\n\r\n"), ("no name", b"GET / HTTP/1.1\r\n" + host + b"\r\n: x\r\n\r\n"),
                       ("LF within", b"GET / HTTP/1.1\r\n" + host + b"\r\nX: a\nOrigin: null\r\n\r\n"),
                       ("CR within", b"GET / HTTP/1.1\r\n" + host + b"\r\nX: a\rOrigin: null\r\n\r\n")):
        yield Attack(name, data, (400, 505))
    for c in b" \t()<>@,;\\\"/[]?={}\x01\x7f\x80\xff":
        yield Attack(f"byte {c} in a header's name", b"GET / HTTP/1.1\r\n" + host + b"\r\nX" + bytes([c]) + b"y: z\r\n\r\n", BAD)
    for c in [*range(1, 9), 11, 12, *range(14, 32), 127]:
        yield Attack(f"byte {c} in a header's value", b"GET / HTTP/1.1\r\n" + host + b"\r\nX: y" + bytes([c]) + b"z\r\n\r\n", BAD)
    for name in ("Host", "Origin", "Cookie", "Authorization", "Connection", "Upgrade", "Sec-Fetch-Site", "Sec-WebSocket-Key",
                 "Sec-WebSocket-Version", "Sec-WebSocket-Protocol", "Content-Length"):
        yield Attack(f"{name} twice", head(server, "GET / HTTP/1.1", f"{name}: 1", f"{name.lower()}: 1"), BAD)


def sizes(server):
    for n in (8200, 16400, 100000):
        yield Attack(f"a target of {n}", head(server, "GET /" + "a" * n + " HTTP/1.1"), (431,))
        yield Attack(f"a header of {n}", head(server, "GET / HTTP/1.1", "X: " + "y" * n), (431,))
        yield Attack(f"a cookie of {n}", head(server, "GET / HTTP/1.1", cookie="a=" + "b" * n), (431,))
        yield Attack(f"a name of {n}", head(server, "GET / HTTP/1.1", "X" * n + ": y"), (431,))
    for n in (120, 1000, 20000):
        yield Attack(f"{n} headers", head(server, "GET / HTTP/1.1", *(f"X{i}: y" for i in range(n))), (431,))


def behind(server):
    """A request, and another one behind it in the same packet: there is one answer, to the first."""
    cookie, right = server.own_cookie, json.dumps({"token": server.token}).encode()
    post = head(server, "POST /session HTTP/1.1", f"Content-Length: {len(right)}") + right
    wrong = head(server, "POST /session HTTP/1.1", "Content-Length: 2") + b"{}"
    put = head(server, "PUT /files/behind HTTP/1.1", "Content-Length: 1", cookie=cookie) + b"x"
    get, evil = head(server, "GET /nothing HTTP/1.1"), raw("GET / HTTP/1.1", "Host: evil")
    evil_put = raw("PUT /files/x HTTP/1.1", "Host: evil", "Content-Length: 1") + b"x"
    late = raw("PUT /files/x HTTP/1.1", "Host: evil", "Content-Length: 1000")
    ws = head(server, "GET /ws HTTP/1.1", "Upgrade: websocket", "Connection: Upgrade", f"Origin: {server.base}", cookie=cookie)
    firsts = {"nothing": (get, 404), "evil": (evil, 403), "evil PUT": (evil_put, 403), "wrong token": (wrong, 403), "token": (post, 204),
              "half an upgrade": (ws, 400)}
    seconds = {"PUT": put, "evil PUT": evil_put, "PUT to come": late, "POST": post, "GET": get, "DELETE": head(
        server, "DELETE /session HTTP/1.1", "Content-Length: 0"), "upgrade": ws, "garbage": b"\0" * 100, "a thousand GETs": get * 1000}
    for one, (first, code) in firsts.items():
        for other, second in seconds.items():
            yield Attack(f"{one}, then {other}", first + second, (code, 429) if one == "wrong token" else (code,))


def upgrades(server):
    good = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13", "Origin": server.base,
            "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Protocol": "volvis"}

    def ask(first="GET /ws HTTP/1.1", cookie=server.own_cookie, more=(), **changes):
        named = {**good, **{k.replace("_", "-"): v for k, v in changes.items()}}
        return head(server, first, *more, *(f"{k}: {v}" for k, v in named.items() if v is not None), cookie=cookie)
    for origin in foreign_origins(server):
        yield Attack(f"upgrade from {short(origin)}", ask(Origin=origin), NO)
    for port in (server.port - 1, server.port + 1, 80, 443, 8888):  # other programs of this host name
        for host in ("localhost", "127.0.0.1", "[::1]"):
            yield Attack(f"upgrade from {host}:{port}", ask(Origin=f"http://{host}:{port}", Sec_Fetch_Site="same-site"), (403,))
            yield Attack(f"upgrade from {host}:{port}, no Sec-Fetch-Site", ask(Origin=f"http://{host}:{port}"), (403,))
    for name, values in (("Upgrade", ("h2c", "websocket2", "websocket, h2c", "h2c, websocket", "", "TLS/1.0", "web socket", "HTTP/2.0")),
                         ("Connection", (None, "keep-alive", "close", "", "Upgraded", "x-upgrade")),
                         ("Sec_WebSocket_Version", (None, "0", "7", "8", "12", "14", "13, 13", "013", "", "x")),
                         ("Sec_WebSocket_Key", (None, "", "x", "dGhlIHNhbXBsZSBub25jZQ", "a" * 25, "a" * 4000)),
                         ("Sec_WebSocket_Protocol", (None, "", "http", "volvis2", "xvolvis", "volvis\x01"))):
        for value in values:
            yield Attack(f"upgrade with {name} {value}", ask(**{name: value}), (400, 426))
    for path in ("/", "/ws/", "//ws", "/ws?x", "/WS", "/ws/..", "/other", "/files/1/x", "/session", "/ws%20", "/ws%00"):
        yield Attack(f"upgrade at {path}", ask(f"GET {path} HTTP/1.1"), BAD)
    for method in ("POST", "PUT", "HEAD", "DELETE", "OPTIONS", "CONNECT"):
        yield Attack(f"upgrade by {method}", ask(f"{method} /ws HTTP/1.1"), BAD)
    for end in ("%0a", "%0d", "%0d%0a", "%0A", "%0a%20", "%250a", "\n", "\r"):
        for name in ("Origin", "Host", "X"):
            yield Attack(f"upgrade at /ws{short(end)}{name}:", ask(f"GET /ws{end}{name}:{'a' * 310} HTTP/1.1", Origin="http://evil.example"), NO)
    yield Attack("upgrade with a body", ask(more=("Content-Length: 5",)) + b"hello", BAD)
    yield Attack("upgrade without a cookie", ask(cookie=None), (403,))
    yield Attack("upgrade without Origin, with the cookie", ask(Origin=None), (403,))
    yield Attack("upgrade without Origin, with the cookie and a wrong token", ask(Origin=None, more=("Authorization: Bearer x",)), (403, 429))
    for cookie in (f"volvis-{server.port}={'0' * 64}", f"volvis-{server.port}=", "x" * 8000, server.own_cookie[:-1], server.own_cookie + "0",
                   server.own_cookie.upper(), server.own_cookie.replace(str(server.port), str(server.port + 1)), f"x{server.own_cookie}"):
        yield Attack(f"upgrade with the cookie {short(cookie[:40])}", ask(cookie=cookie), (403,))
    for site in ("cross-site", "same-site"):
        yield Attack(f"upgrade {site}", ask(Sec_Fetch_Site=site), (403,))
    yield Attack("HTTP/2 by upgrade, foreign Host", raw("GET / HTTP/1.1", "Host: evil.example", "Connection: Upgrade, HTTP2-Settings", "Upgrade: h2c",
                                                        "HTTP2-Settings: AAMAAABkAAQAAP__"), NO)
    yield Attack("HTTP/2 by upgrade", ask("GET / HTTP/1.1", Upgrade="h2c", Connection="Upgrade, HTTP2-Settings", HTTP2_Settings="AAMAAABkAAQAAP__"), BAD)


def tokens(server):
    token, cookie = server.token, server.own_cookie
    shapes = [b"", b"{", b"[]", b"null", b'""', b'{"token": 1}', b'{"token": null}', b'{"token": true}', b'{"token": []}', b'{"token": ""}',
              json.dumps({"token": token[:-1]}).encode(), json.dumps({"token": token + "0"}).encode(), json.dumps({"token": token.upper() + "x"}).encode(),
              json.dumps({"Token": token}).encode(), json.dumps([token]).encode(), json.dumps(token).encode(), token.encode(),
              json.dumps({"token": "\0" + token}).encode(), json.dumps({"token": token + "\0"}).encode(), json.dumps({"token": {"token": token}}).encode(),
              b"token=" + token.encode(), b"[" * 4000, b"\xff" * 100, json.dumps({"token": "x" * 4000}).encode(),
              json.dumps({"token": cookie.split("=")[1]}).encode()]
    for shape in shapes:
        yield Attack(f"token {short(shape)}", head(server, "POST /session HTTP/1.1", f"Content-Length: {len(shape)}") + shape, (403, 429))
    for value in (f"bearer {token}x", f"Basic {token}", f"Bearer  {token}", f"Bearer {token[:-1]}", f"Bearer {token}x", "Bearer ", "Bearer", token,
                  f"Bearer {token} x", f"Bearer\t{token}"):
        yield Attack(f"Authorization {short(value.replace(token, 'TOKEN'))}",
                     head(server, "GET /files/1/x HTTP/1.1", f"Authorization: {value}"), (403, 429))
    right = json.dumps({"token": token}).encode()
    post = head(server, "POST /session HTTP/1.1", f"Content-Length: {len(right)}") + right
    yield Attack("the right token after wrong ones", post, (204,))


def uploads(server):
    cookie = server.own_cookie
    for name in ("", ".", "..", ".hidden", "a/b", "%2f", "a%2fb", "..%2fx", "%2e%2e%2fx", "%2e", "a%00b", "%ff", "a%ffb", "%c3", "%0a", "a" * 128,
                 "a" * 4000, "%41%0d%0ax", "a%7f", "%ed%a0%80", "/etc/passwd", "%2fetc%2fpasswd"):
        yield Attack(f"upload {short(name)}", head(server, f"PUT /files/{name} HTTP/1.1", "Content-Length: 1", cookie=cookie) + b"x", BAD)
    yield Attack("upload without a cookie", head(server, "PUT /files/x HTTP/1.1", "Content-Length: 1") + b"x", (403,))
    for n in (1048577, 10 ** 12, 10 ** 14):
        yield Attack(f"upload of {n} bytes", head(server, "PUT /files/x HTTP/1.1", f"Content-Length: {n}", cookie=cookie) + b"x" * 1000, (413,))


def forms(server):
    """What a page of another origin can make a browser send without being asked first: forms, images, beacons."""
    cookie, body = server.own_cookie, json.dumps({"token": server.token}).encode()
    kinds = ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", "application/json", "text/html")
    for kind in kinds:
        for origin in ("http://evil.example", "null", f"http://localhost:{server.port + 1}"):
            yield Attack(f"form of {kind} from {short(origin)} with the right token",
                         head(server, "POST /session HTTP/1.1", f"Origin: {origin}", "Sec-Fetch-Site: cross-site", "Sec-Fetch-Mode: navigate",
                              f"Content-Type: {kind}", f"Content-Length: {len(body)}", cookie=cookie) + body, NO)
    for site in ("cross-site", "same-site"):
        for first in ("POST /session", "PUT /files/form", "DELETE /session", "POST /files/form"):
            yield Attack(f"{first} {site}, no Origin", head(server, f"{first} HTTP/1.1", f"Sec-Fetch-Site: {site}", f"Content-Length: {len(body)}",
                                                            cookie=cookie) + body, (400, 403, 405))
    for name, value in (("X-HTTP-Method-Override", "DELETE"), ("X-HTTP-Method", "DELETE"), ("X-Method-Override", "PUT"), ("X-Original-URL", "/session"),
                        ("X-Rewrite-URL", "/files/1/x"), ("X-Forwarded-Host", "evil.example"), ("X-Forwarded-For", "127.0.0.1"), ("Forwarded", "host=evil.example"),
                        ("X-Forwarded-Proto", "https")):
        yield Attack(f"{name}: {value} does nothing", head(server, "GET /nothing HTTP/1.1", f"{name}: {value}", cookie=cookie), (404,))
        yield Attack(f"{name}: {value} without a cookie", head(server, "GET /files/1/x HTTP/1.1", f"{name}: {value}"), (403, 404))


def secrets(server):
    """The right token where none belongs, and what was right for others."""
    token, port, origin = server.token, server.port, f"Origin: {server.base}"
    for more in (f"Token: {token}", f"X-Token: {token}", f"X-Auth-Token: {token}", f"Proxy-Authorization: Bearer {token}", f"Referer: http://localhost:{port}/#{token}",
                 f"Sec-WebSocket-Protocol: {token}", f"X-CSRF-Token: {token}", f"Authorization: Token {token}", f"Authorization: Digest {token}"):
        yield Attack(f"the token as {more.split(':')[0]}", head(server, "GET /files/1/x HTTP/1.1", more, origin), (403, 404, 429))
        yield Attack(f"an upload with the token as {more.split(':')[0]}",
                     head(server, "PUT /files/secret HTTP/1.1", more, origin, "Content-Length: 1") + b"x", (403, 429))
    value = server.own_cookie.split("=")[1]
    for cookie in (f"volvis-{port}={token}", f"token={token}", f"session={value}", f"volvis={value}", f"volvis-{port}={value}x", f"volvis-{port} ={value}",
                   f"volvis-{port}= {value}", f'volvis-{port}="{value}"', f"VOLVIS-{port}={value}", f"__Host-volvis-{port}={value}", f"a=b,volvis-{port}={value}"):
        yield Attack(f"the cookie {short(cookie.replace(value, 'COOKIE').replace(token, 'TOKEN'))}",
                     head(server, "PUT /files/secret HTTP/1.1", origin, "Content-Length: 1", cookie=cookie) + b"x", (403,))


HTML = ("<script>alert(1)</script>", "%3Cscript%3Ealert(1)%3C/script%3E", "<img src=x onerror=alert(1)>", '"><svg onload=alert(1)>', "javascript:alert(1)",
        "%3Cimg%20src=x%20onerror=alert(1)%3E")


def markup(server):
    """Names that are HTML: nothing of them is in an answer (attack.NEVER)."""
    for name in HTML:
        for target in (f"/{name}", f"/files/1/{name}", f"/?{name}", f"/session?{name}"):
            yield Attack(f"GET {short(target)}", head(server, f"GET {target} HTTP/1.1", cookie=server.own_cookie),
                         (200, 400) if target.startswith("/?") else (400, 403, 404))  # the page, which is always the same
        yield Attack(f"method {short(name)}", head(server, f"{name} / HTTP/1.1"), (400, 403, 405, 501))
        yield Attack(f"Host {short(name)}", raw("GET / HTTP/1.1", f"Host: {name}"), (400, 403))


def garbage(server):
    for name, data in (("TLS", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 500), ("HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
                       ("SSH", b"SSH-2.0-OpenSSH_9.2\r\n"), ("SOCKS", b"\x05\x01\x00"), ("zeros", b"\0" * 5000), ("lines", b"\r\n" * 5000),
                       ("RDP", b"\x03\x00\x00\x13\x0e\xe0"), ("a proxy's line", b"PROXY TCP4 1.2.3.4 1.2.3.4 1 1\r\n" + head(server, "GET / HTTP/1.1"))):
        yield Attack(name, data + b"\r\n\r\n", (0, 400, 431, 505))
    dice = random.Random(1)
    whole = head(server, "POST /session HTTP/1.1", f"Origin: {server.base}", "Content-Length: 2") + b"{}"
    for i in range(60):
        data = bytearray(whole)
        for _ in range(dice.randrange(1, 4)):
            at = dice.randrange(len(data) - 6)
            data[at:at + dice.randrange(2)] = bytes([dice.choice((0, 9, 10, 13, 32, 34, 37, 44, 58, 127, 128, 255, dice.randrange(256)))])
        yield Attack(f"mutant {i}", bytes(data) + b"\r\n\r\n" * 2, (0, 400, 403, 404, 405, 411, 413, 429, 431, 505))


FAMILIES = (hosts, origins, lengths, codings, targets, ways_out, methods, lines, sizes, behind, upgrades, uploads, forms, secrets, markup, garbage, tokens)
