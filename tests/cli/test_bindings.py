"""Files that say what buttons and keys do: read strictly, printed, and a part of recordings."""
import json
import os

from harness import Skip, fails, main, ok, says

EXAMPLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../examples/bindings.json")


def printed(*words):
    return json.loads(ok("view", "--print-bindings", *words).text)["bindings"]


def file(text, name="keys.json"):
    with open(name, "w", encoding="utf-8") as out:
        out.write(text)
    return name


def refused(text, *words):
    says(fails(3, "view", "--print-bindings", "--bindings", file(text)), "keys.json", *words)


def test_what_is_printed_reads_back_as_the_same():
    plain = ok("view", "--print-bindings").text
    assert plain == ok("serve", "--print-bindings").text
    assert plain == ok("view", "--print-bindings", "--bindings", file(plain)).text
    rows = json.loads(plain)["bindings"]
    assert rows["turn"] == {"device": "mouse", "when": "left", "method": "turntable"}
    assert plain.count("\n") == len(rows) + 2, "a row a line"


def test_the_example_changes_adds_and_takes_away():
    before, after = printed(), printed("--bindings", EXAMPLE)
    with open(EXAMPLE, encoding="utf-8") as example:
        rows = json.load(example)["bindings"]
    assert any(row is None for row in rows.values()) and any(name not in before for name in rows)
    for name, row in rows.items():
        assert after.get(name) == row, name
    assert all(after[name] == row for name, row in before.items() if name not in rows)


def test_a_key_that_is_bound_anew_does_its_old_thing_no_more():
    rows = printed("--bindings", file('{"bindings": {"mine": {"device": "keyboard", "when": "R", "method": "step-roll"}}}'))
    assert [name for name, row in rows.items() if row.get("when") == "R"] == ["mine"]


def test_what_is_wrong_is_said_with_the_line_and_the_nearest_name():
    row = '{"device": "keyboard", "when": "Q",\n"method": "%s"%s}'
    head = '{"bindings": {\n"a": null,\n"b": '
    good = '{"bindings": {"fit": null,\n"b": '
    refused("", "line 1")
    refused('{"bindings": {\n"turn": }}', "line 2")
    refused('{"bindings": []}', '{"bindings": {...}}')
    refused('{"binding": {}}', '"binding"')
    refused(head + row % ("step-roll", "") + "}}", "line 2", "a: there is no such binding")
    refused('{"bindings": {"tunr": null}}', "line 1", "the nearest is turn")
    refused(good + row % ("step-rol", "") + "}}", "line 3", 'b: there is no method "step-rol"', "the nearest is step-roll")
    refused(good + row % ("action", ', "action": "fti"') + "}}", "line 3", 'no action "fti"', "the nearest is fit")
    refused(good + row % ("action", "") + "}}", "needs the name of an action")
    refused(good + row % ("step-roll", ',\n"gian": 2') + "}}", "line 4", "gian", "gain")
    refused(good + row % ("step-roll", ',\n"gain": 1000') + "}}", "line 4", "b: ", "100")
    refused(good + '{"device": "keyboard", "when": "Ctrl+Q", "method": "step-roll"}}}', "line 2", '"Ctrl" is not Shift', "Control")
    refused(good + '{"device": "mose", "when": "left", "method": "pan"}}}', 'no device "mose"', "the nearest is mouse")
    refused(good + '{"device": "mouse", "when": "lefd", "method": "pan"}}}', 'no button "lefd"', "the nearest is left")
    refused(good + '{"device": "mouse", "when": "left", "method": "touch"}}}', "touch is for touch")
    refused(good + '{"device": "mouse", "method": "pan"}}}', "line 2", "b: is missing: a button, key or axis")
    says(fails(3, "view", "--bindings", "nothing.json"), "nothing.json")


def test_keys_and_actions_that_are_none_and_keys_bound_twice_are_refused():
    def rows(*whens, device="keyboard", does='"method": "step-roll"'):
        return '{"bindings": {' + ",\n".join('"b%d": {"device": "%s", "when": "%s", %s}' % (i, device, when, does)
                                            for i, when in enumerate(whens)) + "}}"
    refused(rows("NoSuchKey"), "line 1", 'b0: there is no key "NoSuchKey"')
    refused(rows("Shift+ArowLeft"), 'no key "ArowLeft"', "the nearest is ArrowLeft")
    refused(rows("Shift+Shift+Q"), '"Shift+Shift+Q" has a modifier twice')
    refused(rows("W+W+left", device="mouse", does='"method": "pan"'), "has a modifier twice")
    refused(rows("q"), "letters are written as capitals")
    refused(rows("Alt+1"), "Digit1")
    refused(rows(" "), "Space")
    refused(rows("Q", "Q"), "line 2", 'b1: Q is already bound to "b0"')
    refused(rows("Control+Shift+Q", "E", "Shift+Control+Q"), "line 3", 'b2: Shift+Control+Q is already bound to "b0"')
    for action, nearest in (("operation-gausian", "gaussian"), ("operation-nope", ""), ("renderer-raycats", "raycast"),
                            ("preset-heda", "head"), ("preset-", "")):
        refused(rows("Q", does='"method": "action", "action": "%s"' % action), "line 1", "b0: there is no", nearest)
    for fine in (rows("Q", "Shift+Q", "\u00e4", "+", "Shift++", "Digit1", "F24", "PageUp", "Space", "\u20ac"),
                 rows("left", "Shift+left", device="mouse", does='"method": "pan"'),
                 '{"bindings": {"a": {"device": "mouse", "when": "right", "method": "pan"},'
                 '"b": {"device": "mouse", "when": "right", "method": "click", "action": "center"}}}'):
        ok("view", "--print-bindings", "--bindings", file(fine))


def test_a_recording_keeps_the_bindings_that_were_in_use():
    try:
        from page import Page, Server, run
    except ImportError as error:
        raise Skip("the system's python has no websockets") from error
    empty = file('{"schema": 1, "views": {"main": {"camera": {"eye": [0, -10, 0], "at": [0, 0, 0]}}}, "volumes": {}}', "empty.vv.json")
    mine = file('{"bindings": {"turn": {"device": "mouse", "when": "left", "method": "pan"}}}')

    async def work():
        async with Page(server) as page:
            assert page.messages[0]["bindings"]["bindings"]["turn"]["method"] == "pan"
            await page.until(lambda: page.pose)
            assert abs(page.pose["at"][0]) < 1e-9
            await page.say("events", lines="0 mouse axis x 0\n1 mouse axis y 0\n2 mouse button left down\n"
                           "3 mouse axis x 0.5\n4 mouse button left up\n")
            await page.until(lambda: page.pose["at"][0] < -0.1)
            await page.ask("save", path=os.path.abspath("live.vv.json"))
    with Server(empty, "--bindings", mine, "--record", "session.jsonl") as server:
        run(work())
    os.remove(mine)
    ok("replay", "session.jsonl", "-o", os.path.abspath("played.vv.json"))
    with open("live.vv.json", "rb") as live, open("played.vv.json", "rb") as played:
        assert live.read() == played.read()
    with open("session.jsonl", encoding="utf-8") as recording:
        lines = recording.read().split("\n")
    first = json.loads(lines[0])
    first["bindings"]["turn"]["method"] = "pna"
    file("\n".join([json.dumps(first), *lines[1:]]), "bad.jsonl")
    says(fails(2, "replay", "bad.jsonl"), "bad.jsonl:line 1", "the nearest is pan")


main()
