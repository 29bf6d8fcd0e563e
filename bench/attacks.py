"""What a hostile neighbour does to a server while others look: each begins with the server, and gives back what ends it."""
import socket
import threading
import time
import urllib.error
import urllib.request

from pages import message


def _repeat(work):
    """In a thread, until it is ended."""
    stop = threading.Event()

    def run():
        while not stop.is_set():
            try:
                work()
            except OSError:
                stop.wait(0.01)
    thread = threading.Thread(target=run)
    thread.start()

    def end():
        stop.set()
        thread.join()
    return end


def slow_heads(server, _):
    """A thousand connections that give a byte of a head now and then, and come again when they are thrown out."""
    sockets = []

    def work():
        while len(sockets) < 1000:
            sock = socket.create_connection(("127.0.0.1", server.port))
            sock.sendall(b"GET / HTTP/1.1\r\nHost: loc")
            sockets.append(sock)
        time.sleep(0.2)
        for sock in list(sockets):
            try:
                sock.sendall(b"a")
            except OSError:
                sock.close()
                sockets.remove(sock)
    stop = _repeat(work)

    def end():
        stop()
        for sock in sockets:
            sock.close()
    return end


def floods(server, crowd):
    """A page that sends more messages than a server takes, again and again."""
    def work():
        page = type(crowd.pages[0])(crowd_of_nobody(server), 0, (64, 64), True)
        page.socket.setblocking(True)
        page.socket.settimeout(5)
        for _ in range(50):
            page.socket.sendall(message('{"type": "action", "name": "front"}') * 100)
        page.socket.close()
        time.sleep(0.1)
    return _repeat(work)


def crowd_of_nobody(server):
    """What a page needs of its crowd, for one who belongs to none."""
    class Nobody:
        errors, receive_buffer = [], None

        def drop(self, page):
            page.socket.close()
    nobody = Nobody()
    nobody.server = server
    return nobody


def refused_requests(server, _):
    """Requests under a foreign name, with wrong tokens and to wrong places, one after the other."""
    def work():
        for path, data, host in (("/", None, "evil.example"), ("/session", b'{"token": "x"}', f"localhost:{server.port}"),
                                 ("/../../etc/passwd", None, f"localhost:{server.port}")):
            request = urllib.request.Request(f"http://127.0.0.1:{server.port}{path}", data=data, headers={"Host": host})
            try:
                urllib.request.urlopen(request, timeout=5).close()
            except urllib.error.HTTPError as error:
                error.close()
    return _repeat(work)


attacks = {"1000 slow heads": slow_heads, "floods of messages": floods, "refused requests": refused_requests}
