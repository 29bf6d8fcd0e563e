"""A server of its own for each test, and plain requests to it: the standard library is enough."""
import json
import os
import signal
import subprocess
import urllib.error
import urllib.request

from harness import VOLVIS, environment


class Server:
    """A server of its own state folder; `with` ends it as Ctrl-C does."""

    def __init__(self, *words, verb="view", state="state", browser=False):
        own = ["--no-browser"] if verb == "view" and not browser else []
        self.process = subprocess.Popen([VOLVIS, verb, *own, "--json", *map(str, words)], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, env=environment(XDG_STATE_HOME=os.path.abspath(state)))
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError("no link: " + self.process.communicate()[1].decode())
        self.link = json.loads(line)["link"]
        self.base, self.token = self.link.split("/#")
        self.port = int(self.base.rsplit(":", 1)[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end(signal.SIGINT)

    def end(self, how):
        """Its exit code and what it said."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        said = self.process.communicate(timeout=60)[1].decode()
        assert "Sanitizer" not in said, said
        return self.process.returncode, said

    def request(self, path, data=None, method=None, **headers):
        """Status, headers and body, whatever the status is."""
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", data=data, method=method,
                                         headers={"Host": f"localhost:{self.port}", **named})
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, answer.headers, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.headers, error.read()

    def cookie(self, token=None):
        code, headers, body = self.request("/session", json.dumps({"token": token or self.token}).encode())
        assert code == 204, (code, body)
        return headers["set-cookie"].split(";")[0]
