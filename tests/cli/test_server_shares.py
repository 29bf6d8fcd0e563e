"""What people of one server share: its time, by turns, and its disk, in folders of their own."""
import json
import os

import numpy as np

from harness import main, ok, write_ball
from page import Page, Server, run
from wire import attacked, connect, frame, head, hello, upgrade, wait_for


def files():
    """Names of all that was written for a session, with the folder that each lies in."""
    return {os.path.join(os.path.basename(folder), name) for folder, _, names in os.walk("state") for name in names
            if os.path.basename(folder) not in ("state", "volvis") and not name.startswith("journal")}


def names():
    """Of all files below the root that are not the session's own."""
    return sorted(os.path.join(folder, name) for folder, _, files in os.walk(".") for name in files if not folder.startswith("./state"))


def put(server, name, data):
    code, _, body = server.request(f"/files/{name}", data, method="PUT", Cookie=server.cookie())
    assert code == 201, (code, body)
    return json.loads(body)["path"]


# Time ---------------------------------------------------------------------------------------------------------------

def ask_and_leave(server, cookie, message, n):
    sock, got = upgrade(server, cookie)
    assert b" 101 " in got, got
    sock.sendall(hello() + b"".join(frame(json.dumps({**message, "id": i + 1}).encode()) for i in range(n)))
    return sock


def test_what_someone_asked_who_has_left_keeps_nobody_waiting():
    # a picture of that size takes some minutes here
    large = {"type": "picture", "width": 8192, "height": 8192, "name": "large.png"}
    with attacked("--spp", "16") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
                gone = ask_and_leave(server, server.cookie(), large, 64)
                await page.until(lambda: any(m["type"] == "job" and m["name"] == "picture" for m in page.messages))
                url = page.ask("picture", width=30, height=20)
                gone.close()
                assert (await url)["url"], "behind 64 pictures of someone who is gone"
                answers = [m for m in page.messages if m["type"] == "job" and m["state"] == "done"]
                assert len(answers) == 1, answers
        run(work())


def test_what_is_soon_done_waits_for_no_ones_large_picture():
    # a picture of that size takes some minutes here
    with attacked("--spp", "16") as server:
        async def work():
            async with Page(server, 64, 64) as busy, Page(server, 64, 64) as other, Page(server, 64, 64) as third:
                await other.resting()
                await busy.say("picture", id=1000, width=8192, height=8192, name="large.png")
                large = await other.until(lambda: next((m for m in other.messages if m.get("type") == "job" and
                                                        m["state"] == "running"), None))
                await busy.say("picture", id=1001, width=20, height=20)  # their own, in order
                await third.say("picture", id=1002, width=4096, height=4096)  # as large: one at a time
                assert (await other.ask("picture", width=30, height=20))["url"], "behind another's large picture"
                dataset = next(iter(other.world["world"]["datasets"]))
                made = await other.ask("run", operation="gaussian", dataset=dataset, parameters={"sigma": 1})
                assert made["dataset"], made
                running = [m for m in other.messages if m["type"] == "job" and m["job"] == large["job"]]
                assert all(m["state"] == "running" for m in running), running
                assert not any(m.get("id") == 1001 for m in busy.messages), "out of order"
                assert await other.ask("cancel", job=large["job"])
                await busy.until(lambda: any(m.get("id") == 1001 and m["ok"] for m in busy.messages))
                for number in range(1, 10):
                    await other.ask("cancel", job=number)
        run(work())


def test_jobs_that_take_minutes_keep_nobody_else_waiting():
    write_ball("small.nrrd", 16)
    ok("resample", "small.nrrd", "--dims", "200,200,200", "-o", "ball.nrrd")
    with Server("ball.nrrd", "--root", ".", verb="serve") as server:
        async def work():
            long = {"operation": "median", "dataset": "ball", "parameters": {"radius": "9vox"}}  # about a minute alone
            async with Page(server, 64, 64) as one, Page(server, 64, 64) as two, Page(server, 64, 64) as three, \
                    Page(server, 64, 64) as four, Page(server, 64, 64) as five:
                await four.resting()
                for page in (one, two, three):
                    for number in (1000, 1001):
                        await page.say("run", id=number, **long)
                running = await four.until(lambda: (jobs := {m["job"] for m in four.messages if m["type"] == "job"
                                                             and m["state"] == "running"}) and len(jobs) == 3 and jobs)
                assert (await four.ask("picture", width=64, height=64, name="p.png"))["url"]
                assert await five.ask("open", path="small.nrrd", add=True) is None
                ended = [m for m in four.messages if m["type"] == "job" and m["job"] in running and m["state"] != "running"]
                assert not ended, ended
                for number in range(1, 10):
                    await four.ask("cancel", job=number)
        run(work())


def test_each_has_a_share_of_what_waits():
    with attacked("--spp", "16") as server:
        async def work():
            async with Page(server, 64, 64) as greedy, Page(server, 64, 64) as other:
                for i in range(40):
                    await greedy.say("picture", id=1000 + i, width=500, height=500, name="x.png")
                refused = await greedy.until(lambda: [m for m in greedy.messages if m["type"] == "answer" and not m["ok"]][22:])
                assert all("jobs of yours are already waiting" in m["error"] for m in refused), refused
                await other.say("picture", id=7, width=40, height=30)
                first = await other.until(lambda: next((m for m in other.messages if m.get("type") == "job" and
                                                        m["state"] == "running"), None))
                # after the one that ran, and one more at most
                await other.until(lambda: any(m.get("id") == 7 for m in other.messages))
                ran = {m["job"] for m in other.messages if m["type"] == "job" and m["state"] == "done"}
                assert len(ran) <= 3, (first, ran)
                for number in range(1, 60):  # anybody may end what works on the World of all
                    await other.ask("cancel", job=number)
        run(work())


def test_who_may_only_look_writes_nothing_and_gets_less():
    write_ball("ball.nrrd", 16)
    with Server("ball.nrrd", "--read-only", "--root", ".", "--spp", "16", verb="serve") as server:
        async def look():
            async with Page(server, 64, 64) as page, Page(server, 64, 64) as other:
                await page.resting()
                said = await page.refused("picture", width=8192, height=8192)
                assert "can only be looked at" in said and "8388608 pixels" in said, said
                urls = [(await page.ask("picture", width=50 + i, height=40, name="mine.png"))["url"] for i in range(6)]
                codes = [server.request(url, Cookie=server.cookie())[0] for url in urls]
                assert codes == [404, 404, 200, 200, 200, 200], codes
                for again in range(2):
                    _, _, data = server.request(urls[-1], Cookie=server.cookie())
                    with open("mine.png", "wb") as file:
                        file.write(data)
                    ok("render", "mine.png", "-o", "made.png")
                assert not {name for name in files() if "png" in name}, files()
                for i in range(10):
                    await page.say("picture", id=1000 + i, width=2900, height=2890)
                refused = await page.until(lambda: [m for m in page.messages if m["type"] == "answer" and not m["ok"]][5:])
                assert "4 jobs of yours are already waiting" in refused[0]["error"], refused
                job = (await other.until(lambda: next((m for m in other.messages if m.get("type") == "job" and
                                                       m["state"] == "running"), None)))["job"]
                assert await other.ask("cancel", job=job) is False, "it is another's"
                await page.socket.close()
                assert (await other.ask("picture", width=20, height=20))["url"]
                assert server.request(urls[-1], Cookie=server.cookie())[0] == 404, "kept for who has left"
        run(look())


def written():
    """All that the server has on the disk, and how large it is."""
    return {path: os.stat(path).st_size for folder, _, names in os.walk(".") for path in (os.path.join(folder, n) for n in names)}


def test_what_those_who_only_look_are_shown_is_on_no_disk():
    write_ball("ball.nrrd", 16)
    with Server("ball.nrrd", "--read-only", "--root", ".", verb="serve") as server:
        async def look():
            async with Page(server, 64, 64) as page, Page(server, 64, 64) as other:
                await page.resting()
                before = written()
                pose = page.pose
                await page.say("events", lines="0 mouse axis x 0\n0 mouse button left down\n1 mouse axis x 0.3\n")
                await page.until(lambda: page.pose["eye"] != pose["eye"] and not page.pose["moving"])
                await page.resting()
                shapes = [await who.ask("shape", method=method) for who in (page, other) for method in ("reduced", "boxes")]
                for part in (part for shape in shapes for part in shape["parts"]):
                    for _ in range(2):  # as often as it is asked for
                        code, _, data = server.request(part["url"], Cookie=server.cookie())
                        assert code == 200 and len(data) == part["bytes"] and data[:4] == b"VVS1", part
                await page.ask("picture", width=20, height=20)
                assert written() == before
        run(look())


# Room on the disk ---------------------------------------------------------------------------------------------------

def test_uploads_samples_and_pictures_have_one_limit_and_what_nobody_sees_goes_first():
    write_ball("ball.nrrd", 16)
    with open("ball.nrrd", "rb") as file:
        ball = file.read()
    with attacked("--limit", "session_bytes=26K") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                unseen, seen = put(server, "unseen.nrrd", b"x" * 4000), put(server, "seen.nrrd", ball)
                await page.ask("open", path=seen, add=True)
                for path in (unseen, seen):
                    os.utime(path, (1, 1))
                    os.utime(os.path.dirname(path), (1, 1))
                await page.ask("undo")
                assert put(server, "other.nrrd", ball)
                assert not os.path.exists(os.path.dirname(unseen)), "nobody sees it"
                assert os.path.exists(seen), "redo would have brought it back"
                before = files()
                for kind, more in (("sample", {"name": "orbital"}), ("picture", {"width": 200, "height": 200})):
                    said = await page.refused(kind, **more)
                    assert "no room for" in said and "session_bytes" in said, said
                code, _, said = server.request("/files/more.nrrd", b"x" * 40000, method="PUT", Cookie=server.cookie())
                assert code == 413 and b"no room" in said, (code, said)
                await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"})  # which takes none
                assert files() == before
                assert put(server, "small", b"x")
        run(work())


def test_files_without_bytes_take_room_too():
    with attacked("--limit", "session_bytes=100K") as server:  # 8 KiB a file at least
        cookie, codes = server.cookie(), []
        for i in range(20):
            codes.append(server.request(f"/files/empty-{i}.nrrd", b"", method="PUT", Cookie=cookie)[0])
        assert codes == [201] * 13 + [413] * 7, codes


def test_what_pages_write_comes_out_of_the_same_room():
    write_ball("ball.nrrd", 16)
    write_ball("large.nrrd", 64)  # 262144 samples of a byte
    with attacked("--limit", "session_bytes=100K", verb="serve") as server:  # 8 KiB a file at least: 12 of them
        async def work():
            async with Page(server, 64, 64) as page:
                await page.ask("open", path="ball.nrrd")
                await page.ask("open", path="large.nrrd", add=True)
                for i in range(30):  # what takes the place of the same takes no more
                    await page.ask("write", dataset="ball", path="same.nrrd", replace=True)
                for i in range(6):
                    await page.ask("write", dataset="ball", path=f"ball-{i}.nii")
                for i in range(5):
                    await page.ask("save", path=f"scene-{i}")
                there = names()
                for kind, more in (("write", {"dataset": "ball", "path": "more.nrrd"}), ("save", {"path": "more"}),
                                   ("write", {"dataset": "ball", "path": "more.zarr"}), ("sample", {"name": "orbital"})):
                    said = await page.refused(kind, **more)
                    assert "no room for" in said and "96.0 KiB of 100.0 KiB" in said and "session_bytes" in said, said
                code, _, said = server.request("/files/more.nrrd", b"x" * 20000, method="PUT", Cookie=server.cookie())
                assert code == 413 and b"no room" in said, (code, said)
                await page.ask("write", dataset="ball", path="ball-0.nii", replace=True)
                with open("ball-0.nii", "rb") as file:
                    before = file.read()
                for path in ("ball-0.nii", "large.nii", "large.zarr", "large.nhdr"):  # in the middle of it
                    said = await page.refused("write", dataset="large", path=path, replace=True)
                    assert "no room for" in said and "session_bytes" in said, said
                with open("ball-0.nii", "rb") as file:
                    assert file.read() == before
                assert names() == there, set(names()) ^ set(there)
        run(work())


def test_what_pages_write_over_larger_files_gives_room_back():
    write_ball("ball.nrrd", 16)
    write_ball("large.nrrd", 64)
    with attacked("--limit", "session_bytes=300K", verb="serve") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.ask("open", path="ball.nrrd")
                await page.ask("open", path="large.nrrd", add=True)
                for _ in range(3):
                    await page.ask("write", dataset="large", path="a.nii", replace=True)
                    assert "no room for" in await page.refused("write", dataset="large", path="b.nii")
                    await page.ask("write", dataset="ball", path="a.nii", replace=True)
        run(work())


# Names --------------------------------------------------------------------------------------------------------------

def test_uploads_samples_and_pictures_leave_each_other_alone():
    write_ball("ball.nrrd", 16)
    with open("ball.nrrd", "rb") as file:
        ball = file.read()
    with attacked() as server:
        async def work():
            async with Page(server, 64, 64) as page:
                names = ["result-1.nrrd", "result-2.nrrd", "orbital.nrrd", "1-volvis.png", "ball.nrrd", "ball.nrrd"]
                paths = [put(server, name, ball) for name in names]
                assert len(set(map(os.path.dirname, paths))) == len(names), paths
                assert [os.path.basename(path) for path in paths] == names
                await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "1vox"})
                await page.ask("run", operation="gaussian", dataset="ball", parameters={"sigma": "2vox"})
                await page.ask("picture", width=20, height=20)
                await page.until(lambda: len(page.world["world"]["datasets"]) == 3)
                await page.ask("sample", name="orbital")
                await page.until(lambda: len(page.world["world"]["datasets"]) == 1)
                [sample] = [d["path"] for d in page.world["world"]["datasets"].values()]
                await page.ask("save", path=os.path.abspath("sample.vv.json"))
                before = os.stat(sample)
                await page.ask("sample", name="orbital")  # a scene shows it: it stays as it is
                after = os.stat(sample)
                assert (before.st_ino, before.st_mode, before.st_mtime_ns) == (after.st_ino, after.st_mode, after.st_mtime_ns)
                for path in paths:
                    with open(path, "rb") as file:
                        assert file.read() == ball, path
                assert sample not in paths
        run(work())
    ok("render", "sample.vv.json", "-o", "sample.png")


def test_no_scene_is_saved_where_the_server_deletes_and_none_without_a_name():
    with attacked() as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
                upload = put(server, "u.nrrd", b"x")
                for folder in (os.path.dirname(upload), os.path.dirname(os.path.dirname(upload))):
                    said = await page.refused("save", path=os.path.join(folder, "mine.vv.json"))
                    assert "deleted when the server ends" in said, said
                for name in (".", "..", "sub/", "y.vv.json/", os.path.abspath(".") + "/."):
                    said = await page.refused("save", path=name)
                    assert "expected the name of a file" in said, (name, said)
        run(work())
    assert not [name for name in files() if name.endswith(".vv.json")], files()


def test_a_body_that_waits_for_a_word_gets_it():
    with attacked() as server:
        with connect(server) as sock:
            sock.sendall(head(server, "PUT /files/waits.raw HTTP/1.1", "Content-Length: 3", "Expect: 100-continue",
                              cookie=server.cookie()))
            sock.settimeout(60)
            assert sock.recv(1000) == b"HTTP/1.1 100 Continue\r\n\r\n"
            sock.sendall(b"abc")
            assert sock.recv(1000).startswith(b"HTTP/1.1 201 ")
        with connect(server) as sock:  # who may not is told that, not to go on
            sock.sendall(head(server, "PUT /files/waits.raw HTTP/1.1", "Content-Length: 3", "Expect: 100-continue"))
            assert sock.recv(1000).startswith(b"HTTP/1.1 403 ")


def header(name):
    return (f"ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = {name}\n").encode()


def test_a_header_reads_what_came_with_it_and_nothing_else():
    write_ball("ball.nrrd", 16)
    samples = [bytes([value]) * 64 for value in (10, 200)]
    with attacked() as server:
        async def work():
            async with Page(server, 64, 64) as page:
                put(server, "a.raw", samples[0])  # somebody else's
                alone = put(server, "a.mhd", header("a.raw"))
                assert "a.raw" in await page.refused("open", path=alone)
                for value, batch in zip((10, 200), ("a" * 16, "0123456789abcdef" * 2)):
                    data = put(server, f"{batch}/a.raw", samples[value == 200])
                    path = put(server, f"{batch}/a.mhd", header("a.raw"))
                    assert os.path.dirname(data) == os.path.dirname(path)
                    await page.ask("open", path=path)
                    assert (await page.ask("histogram"))["max"] == value
                again = put(server, f"{batch}/a.raw", samples[0])  # two of one name: the first stays
                assert os.path.basename(again) == "1-a.raw"
                await page.ask("save", path=os.path.abspath("kept.vv.json"))
                for name in ("short/a.raw", f"{'a' * 65}/a.raw", f"{'a' * 16}/b/a.raw", f"{'a' * 15}-/a.raw", f"{'a' * 16}/.."):
                    assert server.request(f"/files/{name}", b"x", method="PUT", Cookie=server.cookie())[0] == 400, name
        run(work())
    with open("kept.vv.json", encoding="utf-8") as file:
        [data] = json.load(file)["datasets"].values()
    ok("convert", data["path"], "-o", "kept.npy")  # its samples stay too
    assert (np.load("kept.npy") == 200).all()
    kept = {name for name in files() if name.endswith((".raw", ".mhd"))}
    assert len(kept) == 3, kept  # all that came with it


def test_what_fails_leaves_no_folder():
    with attacked() as server:
        async def work():
            async with Page(server, 64, 64) as page:
                said = await page.refused("run", operation="gaussian", dataset="ball", parameters={"sigma": "1" * 70000})
                assert said.endswith("at most 65536 are allowed"), said
                for _ in range(5):
                    assert await page.refused("run", operation="isosurface", dataset="ball", parameters={"iso": 1e9})
        run(work())
        assert not [folder for folder, _, _ in os.walk("state") if "result-" in folder]
        cookie = server.cookie()
        with connect(server) as sock:
            sock.sendall(head(server, "PUT /files/broken.nrrd HTTP/1.1", "Content-Length: 1000", cookie=cookie) + b"x")
            wait_for(lambda: [folder for folder, _, _ in os.walk("state") if "upload-" in folder], "a file is being written")
        wait_for(lambda: not [folder for folder, _, _ in os.walk("state") if "upload-" in folder], "its folder goes too")


if __name__ == "__main__":
    main()
