"""What goes wrong around a server while people work: files that shrink, disks that are full, journals that cannot be played."""
import contextlib
import json
import os
import resource
import shutil
import signal
import subprocess

import served
from harness import VOLVIS, Skip, environment, fails, main, ok, write_ball, write_large
from page import Page, Server, run
from wire import wait_for

try:
    import websockets  # noqa: F401
except ImportError as error:
    raise SystemExit(f"[  SKIPPED ] {error}: python3-websockets is missing")


class Limited(Server):
    """Its files may be made no larger, from some time on: the same as a full disk to whoever writes."""

    def __init__(self, *words, state="state"):
        self.process = subprocess.Popen(
            [VOLVIS, "view", "--no-browser", "--json", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env=environment(XDG_STATE_HOME=os.path.abspath(state)))
        self.link = json.loads(self.process.stdout.readline())["link"]
        self.base, self.token = self.link.split("/#")
        self.port = int(self.base.rsplit(":", 1)[1])

    def disk(self, n):
        _, most = resource.prlimit(self.process.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(self.process.pid, resource.RLIMIT_FSIZE, (most if n is None else n, most))


def assert_kept_on_full_disk(work, title):
    """After work(server) and a kill the session goes on with this title, and nothing is lost."""
    server = Limited("head.nrrd")
    run(work(server))
    server.end(signal.SIGKILL)
    with Server("head.nrrd") as again:
        async def check():
            async with Page(again) as page:
                assert page.world["world"].get("title") == title
                assert not told(page, "later changes are lost", "warning")
        run(check())


def found(name, folder="state"):
    return [os.path.join(at, name) for at, _, names in os.walk(folder) if name in names]


def told(page, part, level):
    return [m for m in page.messages if m["type"] == "notice" and m["level"] == level and part in m["text"]]


# Files ---------------------------------------------------------------------------------------------------------------

def test_a_shown_file_that_is_replaced_or_shortened_ends_no_server():
    write_large("shown.nrrd", 160)
    write_ball("other.nrrd", 16)
    size = os.path.getsize("shown.nrrd")
    shutil.copy("shown.nrrd", "whole.nrrd")

    async def work(server):
        async with Page(server, 512, 512) as page:
            await page.resting()
            for i in range(6):
                await page.edit(("set", "background", ["black", "white"][i % 2]))
                with open("shown.nrrd", "r+b") as file:  # in the same file, while it is drawn
                    file.truncate(size // 3 if i % 2 else 4096)
                await page.edit(("set", "title", f"{i}"))
                assert server.process.poll() is None, f"the server has ended: {server.process.returncode}"
                shutil.copyfile("other.nrrd" if i % 3 else "whole.nrrd", "shown.nrrd")
            await page.edit(("set", "title", "alive"))
            await page.until(lambda: page.world["world"].get("title") == "alive")
    with Server("shown.nrrd") as server:
        run(work(server))


def test_who_opens_a_damaged_file_hears_what_is_missing():
    write_ball("ball.nrrd", 16)
    write_ball("cut.nrrd", 32)
    os.truncate("cut.nrrd", os.path.getsize("cut.nrrd") * 3 // 4)
    for verb in ("serve", "view"):  # by the import program, and without it
        with Server("ball.nrrd", *(("--root", ".") if verb == "serve" else ()), verb=verb) as server:
            async def work():
                async with Page(server, 64, 64) as one, Page(server, 64, 64) as other:
                    await one.resting()
                    await other.resting()
                    for page in (one, other):  # whoever opens it, and again
                        before = len(page.messages)
                        await page.ask("open", path=os.path.abspath("cut.nrrd"))
                        await page.until(lambda page=page, before=before: any(m["type"] == "notice" for m in page.messages[before:]))
                        await one.resting()
                        await other.resting()
                        said = [m for m in page.messages[before:] if m["type"] == "notice"]
                        assert len(said) == 1 and "cut.nrrd: is cut short" in said[0]["text"], said
                        assert said[0]["level"] == "warning", said
                        await page.ask("open", path=os.path.abspath("ball.nrrd"))
                        os.utime("cut.nrrd", (5, len(page.messages)))  # another file: its samples are read anew
                    assert len([m for m in one.messages if m["type"] == "notice"]) == 1, one.messages
            run(work())


def test_a_file_that_shrinks_while_it_is_rendered_is_a_sentence():
    write_large("shown.nrrd", 160)
    shutil.copy("shown.nrrd", "whole.nrrd")
    codes = set()
    for i in range(4):
        shutil.copyfile("whole.nrrd", "shown.nrrd")
        process = subprocess.Popen([VOLVIS, "render", "--quiet", "shown.nrrd", "-o", "x.png", "--overwrite", "--size", "600x600",
                                    "--set", "views.main.render.samples=4"], stderr=subprocess.PIPE, env=environment())
        try:
            process.wait(0.1 + 0.1 * i)
        except subprocess.TimeoutExpired:
            pass  # it is at work
        os.truncate("shown.nrrd", 4096)
        said = process.communicate(timeout=60)[1].decode()
        assert process.returncode >= 0, (process.returncode, said)
        assert process.returncode == 0 or said.count("\n") == 1, said
        codes.add(process.returncode)
    assert codes <= {0, 3, 4, 7}, codes


def test_figures_of_a_file_that_shrinks_meanwhile_are_not_told():
    """Two slices, so that nobody asks for more samples after the first ones were found to be gone."""
    for name in ("whole.nrrd", "b.nrrd"):
        with open(name, "wb") as file:
            file.write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5000 4000 2\nencoding: raw\n\n" + b"\7" * 40000000)

    def shrink_when_mapped(process):
        maps = f"/proc/{process.pid}/maps"
        while process.poll() is None:
            with open(maps, encoding="ascii") as file:
                if "a.nrrd" in file.read():
                    os.truncate("a.nrrd", 4096)
                    return
    codes = []
    for _ in range(30):
        shutil.copyfile("whole.nrrd", "a.nrrd")
        process = subprocess.Popen([VOLVIS, "compare", "a.nrrd", "b.nrrd"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment())
        try:
            shrink_when_mapped(process)
        except OSError:
            pass  # it has ended
        out, said = process.communicate(timeout=60)
        codes.append(process.returncode)
        assert process.returncode == 3 and b"shrank" in said and not out or b"nothing differs" in out, (process.returncode, out, said)
        if codes.count(3) == 3:
            return
    raise AssertionError(f"it was always too quick: {codes}")


# Journals ------------------------------------------------------------------------------------------------------------

def leave_a_journal(*words):
    """Of a session that was killed: with a title, a file below `a`, and another title."""
    os.makedirs("a/data"), os.makedirs("b")
    write_ball("a/data/ball.nrrd", 16)
    write_ball("a/data/more.nrrd", 16)

    async def work(server):
        async with Page(server) as page:
            await page.edit(("set", "title", "first"))
            await page.ask("open", path="data/more.nrrd", add=True)
            await page.edit(("set", "title", "last"))
    server = Server("--root", "a", *words, verb="serve")
    run(work(server))
    server.end(signal.SIGKILL)
    with open(found("journal.jsonl")[0], "rb") as journal:
        return journal.read()


def test_a_journal_that_cannot_be_played_is_kept_and_told():
    before = leave_a_journal()
    n = before.count(b"\n")
    with Server("--root", "b", verb="serve") as server:  # where the file that was opened lies outside
        async def work():
            async with Page(server) as page:
                await page.until(lambda: told(page, "journal-1.jsonl", "warning"))
                assert page.world["world"].get("title") != "last"
                await page.edit(("set", "title", "goes on"))
        run(work())
        server.process.kill()
        said = server.process.communicate()[1].decode()
    assert "cannot be played: " in said and "outside" in said and "it is kept as" in said, said
    kept = found("journal-1.jsonl")
    with open(kept[0], "rb") as journal:
        assert journal.read() == before, "the journal is kept as it was"
    os.replace(kept[0], found("journal.jsonl")[0])  # and can be gone on with
    with Server("--root", "a", verb="serve") as server:
        async def again():
            async with Page(server) as page:
                assert page.world["world"].get("title") == "last"
                assert not told(page, "later changes are lost", "warning")
        run(again())
    assert n >= 4


def test_what_others_change_while_a_file_is_opened_beside_stays():
    write_ball("a.nrrd", 16)
    write_ball("b.nrrd", 20)

    async def work(server):
        async with Page(server, 64, 64) as opener, Page(server, 64, 64) as other:
            for i in range(6):
                opener.ids += 1
                await opener.say("open", id=opener.ids, path="b.nrrd", add=True)
                await other.edit(("set", "title", f"title {i}"), ("set", "datasets.a.title", f"data {i}"))
                await opener.until(lambda: any(m["type"] == "answer" and m["id"] == opener.ids and m["ok"] for m in opener.messages))
                await opener.until(lambda: len(opener.world["world"]["datasets"]) == i + 2)
                world = opener.world["world"]
                assert (world.get("title"), world["datasets"]["a"].get("title")) == (f"title {i}", f"data {i}"), world
    with Server("a.nrrd", "--root", ".", verb="serve") as server:
        run(work(server))


# Full disks ----------------------------------------------------------------------------------------------------------

def test_a_full_disk_refuses_changes_before_they_are_made_and_goes_on_when_there_is_room():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page, Page(server, 64, 64) as other:
            await page.edit(("set", "title", "before"))
            server.disk(os.path.getsize(found("journal.jsonl")[0]))
            said = await page.refused("edit", edits=[{"op": "set", "path": "title", "value": "full"}])
            assert "File too large" in said and "not made" in said and "ulimit -f" in said, said  # no room helps there
            await page.until(lambda: page.world["world"].get("title") == "before")
            await other.until(lambda: told(other, "not made", "error"))
            said = await page.refused("undo")
            assert "not made" in said, said
            await page.resting()  # who looks goes on
            server.disk(None)
            await page.edit(("set", "title", "after"))
            await other.until(lambda: told(other, "kept again", "info"))
            await page.edit(("set", "title", "last"))
            await page.until(lambda: page.world["world"].get("title") == "last")
            return page.world["world"]["title"]
    assert_kept_on_full_disk(work, "last")


def test_cameras_of_a_full_disk_come_later_and_undo_is_right_after_it():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page:
            await page.edit(("set", "title", "one"))
            await page.edit(("set", "title", "two"))
            server.disk(0)
            async with Page(server, 64, 64) as newcomer:  # whose view is one that nobody wrote down
                await newcomer.resting()
            await page.refused("edit", edits=[{"op": "set", "path": "title", "value": "full"}])
            server.disk(None)
            await page.edit(("set", "title", "three"))
            await page.ask("undo")
            await page.ask("undo")
            await page.until(lambda: page.world["world"].get("title") == "one")
            await page.ask("redo")
            await page.until(lambda: page.world["world"].get("title") == "two")
    assert_kept_on_full_disk(work, "two")


def test_an_upload_on_a_full_disk_is_told_and_leaves_nothing():
    write_ball(n=16)
    server = Limited("head.nrrd")
    try:
        cookie = server.cookie()
        server.disk(100000)
        code, _, said = server.request("/files/x.bin", b"x" * (4 << 20), method="PUT", Cookie=cookie)
        assert code == 507 and b"disk is full" in said, (code, said)
        assert not found("x.bin")
        server.disk(None)
        assert server.request("/files/x.bin", b"x" * 200000, method="PUT", Cookie=cookie)[0] == 201
        assert len(found("x.bin")) == 1
    finally:
        server.end(signal.SIGINT)


def test_an_uploaded_scene_that_names_what_was_not_uploaded_is_told_so():
    write_ball(n=16)

    async def work(server):
        async with Page(server, 64, 64) as page:
            scene = json.dumps({"schema": 1, "datasets": {"d": {"path": "beside.nrrd"}}, "volumes": {"v": {"data": "d"}}})
            code, _, said = server.request("/files/s.vv.json", scene.encode(), method="PUT", Cookie=server.cookie())
            assert code == 201, said
            answer = await page.answer("open", path=json.loads(said)["path"])
            said = answer["error"] if not answer["ok"] else await page.until(
                lambda: next((m["text"] for m in page.messages if m["type"] == "failed"), None))
            assert "beside.nrrd" in said and "was not uploaded beside" in said, said
    with Server("head.nrrd") as server:
        run(work(server))


SMALL = """#!/bin/sh
mkdir -p state
exec unshare -rm sh -c 'mount -t tmpfs -o size=4m none state && exec "$@"' sh "{volvis}" "$@"
"""


def test_a_disk_that_is_really_full_is_told_to_all_also_to_those_who_come_and_in_the_audit():
    write_ball(n=16)
    if subprocess.run(["unshare", "-rm", "mount", "-t", "tmpfs", "none", "/tmp"], capture_output=True).returncode:
        raise Skip("this system lets us mount no file system of our own")
    with open("small", "w", encoding="ascii") as file:
        file.write(SMALL.format(volvis=VOLVIS))
    os.chmod("small", 0o755)

    async def work(server, fill):
        async with Page(server, 64, 64) as page:
            await page.edit(("set", "title", "before"))
            with open(fill, "wb", buffering=0) as file, contextlib.suppress(OSError):
                while file.write(bytes(4096)):
                    pass
            for n in [1000] * 9 + [300] * 9 + [1] * 9:  # fill the block that the journal has, too
                said = await page.answer("edit", edits=[{"op": "set", "path": "title", "value": "x" * n}])
            assert "not made" in said["error"], said
            async with Page(server, 64, 64) as newcomer:
                await newcomer.until(lambda: told(newcomer, "not made", "error"))
            dataset = next(iter(page.world["world"]["datasets"]))
            said = await page.refused("run", operation="gaussian", dataset=dataset, parameters={"sigma": 1})
            assert "disk is full" in said, said
            code, _, said = server.request("/files/x.bin", b"x" * 9000, method="PUT", Cookie=server.cookie())
            assert code == 507 and b"disk is full" in said, (code, said)
            os.remove(fill)
            await page.edit(("set", "title", "after"))
            async with Page(server, 64, 64) as newcomer:
                await newcomer.heard()
                assert not told(newcomer, "not made", "error")
    whole, served.VOLVIS = served.VOLVIS, os.path.abspath("small")
    try:
        with Server("head.nrrd", "--audit", "audit.jsonl") as server:
            run(work(server, f"/proc/{server.process.pid}/root{os.path.abspath('state')}/fill"))
    finally:
        served.VOLVIS = whole
    with open("audit.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    assert [line.get("refused") for line in lines if line["what"] == "run"] == [True], lines


def test_lines_of_the_audit_that_a_full_disk_lost_are_told():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page:
            server.disk(os.path.getsize("audit.jsonl"))
            await page.refused("open", path="/a-file-that-is-not-there")
            await page.until(lambda: told(page, "cannot be written down", "error"))
            server.disk(None)
            await page.refused("open", path="/another")
            await page.until(lambda: told(page, "written down again", "info"))
    server = Limited("head.nrrd", "--audit", "audit.jsonl")
    run(work(server))
    server.end(signal.SIGINT)
    with open("audit.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    assert any(line["what"] == "lost" and line["lines"] == 1 for line in lines), lines
    assert any(line.get("object") == "/another" for line in lines), lines


def test_a_line_of_the_audit_that_does_not_fit_whole_leaves_no_part_of_it():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page:
            server.disk(os.path.getsize("audit.jsonl") + 30)
            await page.refused("open", path="/a-file-that-is-not-there")
            await page.until(lambda: told(page, "cannot be written down", "error"))
            with open("audit.jsonl", "rb") as file:
                assert file.read().endswith(b"}\n"), "part of a line is left"
            server.disk(None)
            await page.refused("open", path="/another")
    server = Limited("head.nrrd", "--audit", "audit.jsonl")
    run(work(server))
    server.end(signal.SIGINT)
    with open("audit.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    lost = [line["what"] for line in lines].index("lost")
    assert lines[lost + 1]["object"] == "/another", lines


def test_a_recording_on_a_full_disk_has_whole_lines_and_all_are_told():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page:
            await page.resting()
            await page.edit(("set", "title", "before"))
            server.disk(os.path.getsize("session.jsonl") + 30)
            await page.edit(("set", "title", "lost"))
            await page.until(lambda: told(page, "the recording session.jsonl lacks", "error"))
            with open("session.jsonl", "rb") as file:
                assert file.read().endswith(b"}\n"), "part of a line is left"
            server.disk(None)
            await page.edit(("set", "title", "after"))
            await page.until(lambda: told(page, "recorded again", "info"))
    server = Limited("head.nrrd", "--record", "session.jsonl")
    run(work(server))
    server.process.send_signal(signal.SIGINT)
    _, said = server.process.communicate(timeout=60)
    assert server.process.returncode != 0 and b"recording is incomplete" in said, (server.process.returncode, said)
    with open("session.jsonl", encoding="utf-8") as file:
        lines = [json.loads(line) for line in file]
    [at] = [i for i, line in enumerate(lines) if "lost" in line]
    assert "after" in json.dumps(lines[at + 1:]), lines
    said = fails(3, "replay", "session.jsonl", "-o", "again.vv.json")
    n = lines[at]["lost"]
    assert f"line {at + 1}: {n} line{' is' if n == 1 else 's are'} missing" in said, said
    with open("whole.jsonl", "w", encoding="utf-8") as file:
        file.writelines(json.dumps(line) + "\n" for line in lines[:at])
    ok("replay", "whole.jsonl", "-o", "again.vv.json")
    with open("again.vv.json", encoding="utf-8") as file:
        assert json.load(file)["title"] == "before"


# Folders that go -----------------------------------------------------------------------------------------------------

def test_a_session_whose_folder_is_removed_is_kept_in_a_new_one_and_all_are_told():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page, Page(server, 64, 64) as other:
            await page.edit(("set", "title", "before"))
            shutil.rmtree("state")
            await page.edit(("set", "title", "after"))
            await other.until(lambda: told(other, "was removed while it ran", "warning"))
            await page.edit(("set", "title", "last"))
            await page.until(lambda: page.world["world"].get("title") == "last")
            assert len(told(page, "was removed while it ran", "warning")) == 1
    assert_kept_on_full_disk(work, "last")


def test_files_of_a_session_that_were_removed_are_told_with_what_helps():
    write_ball(n=16)
    with Server("head.nrrd") as server:
        async def work():
            async with Page(server, 64, 64) as page:
                await page.resting()
                smooth = {"operation": "gaussian", "parameters": {"sigma": "1vox"}}
                with open("head.nrrd", "rb") as file:
                    _, _, body = server.request("/files/mine.nrrd", file.read(), method="PUT", Cookie=server.cookie())
                await page.ask("open", path=json.loads(body)["path"], add=True)
                shutil.rmtree("state")
                await page.edit(("set", "title", "after"))
                await page.ask("run", dataset="head", **smooth)  # which needs no file of the session
                said = await page.refused("run", dataset="mine", **smooth)
                assert said.endswith("upload all that belongs together at once, or run the operation that made it again") and "state" not in said, said
        run(work())


def test_a_session_whose_folder_cannot_be_made_anew_refuses_changes():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page:
            shutil.rmtree("state")
            with open("state", "wb"):
                pass
            assert "not made" in await page.refused("edit", edits=[{"op": "set", "path": "title", "value": "lost"}])
            os.unlink("state")
            await page.edit(("set", "title", "last"))
            await page.until(lambda: page.world["world"].get("title") == "last")
    assert_kept_on_full_disk(work, "last")


def test_the_journal_of_another_server_in_the_same_place_is_left_alone():
    write_ball(n=16)

    async def work(server):
        async with Page(server) as page:
            journal = found("journal.jsonl")[0]
            os.unlink(journal)
            with open(journal, "wb"):
                pass
            said = await page.refused("edit", edits=[{"op": "set", "path": "title", "value": "lost"}])
            assert "another journal" in said, said
            assert os.path.getsize(journal) == 0
    server = Limited("head.nrrd")
    run(work(server))
    server.end(signal.SIGKILL)


if __name__ == "__main__":
    main()
