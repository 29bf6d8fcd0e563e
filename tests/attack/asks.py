"""Attacks by what a page asks that was let in: each message says whether it is done (True), refused with a sentence (False), or either (None)."""
import os

from attack import Asks, short


def made(id, operation, inputs, **parameters):
    return {"op": "add", "path": "datasets", "id": id, "value": {"operation": operation, "inputs": inputs, "parameters": parameters}}


def edit(*edits):
    return ("edit", {"edits": list(edits)})


def gone(*ids):
    return edit(*({"op": "remove", "path": f"datasets.{id}"} for id in ids))


NO_TEXTS = (None, 5, -1.5, True, [], {}, ["ball"], {"a": 1})
PLACES = ("/etc/x.nrrd", "../x.nrrd", "a/../../x.nrrd", "link/x.nrrd", "file.nrrd/x.nrrd", "link.nrrd", "nobody/x.nrrd", ".", "..", "/", "./", "x.nrrd/",
          "/proc/self/cwd/x.nrrd", "/dev/null", "fifo", "fifo.nrrd", "a" * 300 + ".nrrd", "a/" * 500 + "x.nrrd", "x.xyz", "x", "ball.nrrd", "x\n.nrrd",
          "x.nrrd.part", "full.zarr", "full", "link.zarr", "dangling.nrrd")
QUESTIONS = (*(value for value in NO_TEXTS if value != {}), "volume", {"what": "no"}, {"what": 5}, {"what": "area", "iso": "x"}, {"what": "area", "isos": 5},
             {"what": "volume", "frame": 1 << 60}, {"what": "profile", "points": [[0, 0, 0]] * 3000}, {"what": "profile", "points": 5}, {"what": "histogram", "bins": 1 << 40},
             {"what": "joint", "bins": 1 << 20}, {"what": "length", "points": [[1e308] * 3, [-1e308] * 3]}, {"what": "volume", "data": "/etc/passwd"},
             {"what": "\u0000"}, {"what": "a" * 50000}, {"what": "region", "region": {"kind": "box", "size": [1e308] * 3}})


def prepare():
    """What leads out of the root, and what is no file."""
    os.mkdir("full")
    open("full/file", "w", encoding="ascii").close()
    os.mkdir("full.zarr")
    open("full.zarr/mine.txt", "w", encoding="ascii").close()
    open("file.nrrd", "w", encoding="ascii").close()
    os.symlink("/tmp", "link")
    os.symlink("/tmp/volvis-x.zarr", "link.zarr")
    os.symlink("/etc/passwd", "link.nrrd")
    os.symlink("/tmp/volvis-nobody.nrrd", "dangling.nrrd")
    os.mkfifo("fifo")
    os.mkfifo("fifo.nrrd")


def wrong_types(server):
    """Where a text, a number or a list is expected, others come."""
    for kind, good in (("write", {"dataset": "ball", "path": "new.nrrd", "replace": True}), ("preview", {"operation": "gaussian", "dataset": "ball", "parameters": {}}),
                       ("run", {"operation": "gaussian", "dataset": "ball", "parameters": {}}), ("measure", {"question": {"what": "volume"}})):
        for key in good:
            for value in NO_TEXTS:
                if type(value) is not type(good[key]) and value is not None:
                    yield Asks(f"{kind} with {key} {value}", [(kind, {**good, key: value}, None if key == "replace" else False)])
        yield Asks(f"{kind} with nothing", [(kind, {}, False)])


def places(server):
    for path in PLACES:
        yield Asks(f"write to {short(path)}", [("write", {"dataset": "ball", "path": path, "replace": False}, False)])
        yield Asks(f"write over {short(path)}", [("write", {"dataset": "ball", "path": path, "replace": True}, False)])


def questions(server):
    for question in QUESTIONS:
        yield Asks(f"measure {short(question)}", [("measure", {"question": question}, False)])
    for key in ("volume", "other", "mask", "values"):
        for name in ("nobody", "../ball", "ball.nrrd", "", "a" * 50000):
            yield Asks(f"measure with {key} {short(name)}", [("measure", {"question": {"what": "volume"}, key: name}, False)])


def recipes(server):
    """Data that are made: of themselves, of twice as much each time, of what is not there, with numbers that no machine has room for."""
    asked = [("write", {"dataset": "r", "path": "r.nrrd", "replace": True}, False), ("info", {"dataset": "r"}, False),
             ("preview", {"operation": "gaussian", "dataset": "r", "parameters": {}}, False), (*edit({"op": "set", "path": "volumes.ball.data", "value": "r"}), None),
             ("histogram", {"volume": "ball"}, False), ("measure", {"question": {"what": "volume"}}, False),
             (*edit({"op": "set", "path": "volumes.ball.data", "value": "ball"}), True)]
    yield Asks("made of itself", [(*edit(made("r", "gaussian", {"volume": "r"})), None), *asked, (*gone("r"), None)])
    yield Asks("a ring of two", [(*edit(made("r", "gaussian", {"volume": "s"}), made("s", "gaussian", {"volume": "r"})), None), *asked, (*gone("r", "s"), None)])
    yield Asks("a ring that is closed later", [(*edit(made("r", "gaussian", {"volume": "ball"}), made("s", "gaussian", {"volume": "r"})), True),
                                              (*edit({"op": "set", "path": "datasets.r.inputs", "value": {"volume": "s"}}), None), *asked, (*gone("r", "s"), None)])
    chain = [f"d{i}" for i in range(40)]
    twice = [made(id, "calc", {"a": before, "b": before}, expression="a+b") for id, before in zip(chain, ["ball", *chain])]
    yield Asks("each of twice the one before", [(*edit(*twice), None), ("write", {"dataset": "d39", "path": "d39.nrrd", "replace": True}, None), (*gone(*reversed(chain)), None)])
    larger = [made(id, "pad", {"volume": before}, all=100) for id, before in zip(chain, ["ball", *chain])]
    yield Asks("each larger than the one before", [(*edit(*larger), None), ("preview", {"operation": "gaussian", "dataset": "d39", "parameters": {}}, False), ("info", {"dataset": "d39"}, None),
                                                   (*gone(*reversed(chain)), None)])
    for operation, parameters in (("gaussian", {"sigma": "1e9vox"}), ("gaussian", {"sigma": 1e300}), ("gaussian", {"sigma": -1}), ("gaussian", {"sigma": "nan"}), ("gaussian", {"sigma": []}),
                                  ("pad", {"all": 1 << 40}), ("pad", {"all": -5}), ("resample", {"dims": [1 << 30] * 3}), ("resample", {"spacing": 1e-300}), ("resample", {"dims": "x"}),
                                  ("median", {"radius": 1e9}), ("calc", {"expression": "(" * 50000}), ("calc", {"expression": "a" + "+a" * 20000}), ("calc", {"expression": "/etc/passwd"}),
                                  ("crop", {"from": [-5] * 3}), ("no", {}), ("", {}), ("../gaussian", {}), ("a" * 50000, {}), ("gaussian", {"nobody": 1})):
        for kind in ("run", "preview"):
            yield Asks(f"{kind} {short(operation)} {short(parameters)}", [(kind, {"operation": operation, "dataset": "ball", "parameters": parameters}, False)])
    for inputs in ({"values": "/etc/passwd"}, {"values": "../ball"}, {"volume": "nobody"}, {str(i): "ball" for i in range(3000)}, {"mask": {"path": "/etc/passwd"}}, {"mask": ["ball"] * 9}):
        yield Asks(f"inputs {short(inputs)}", [("preview", {"operation": "mask", "dataset": "ball", "inputs": inputs, "parameters": {}}, False),
                                               ("run", {"operation": "mask", "dataset": "ball", "inputs": inputs, "parameters": {}}, False)])


def storms(server):
    """Many at once, cancelled, and left: others are answered, and so is who stays."""
    preview = ("preview", {"operation": "denoise", "dataset": "ball", "whole": True, "parameters": {}})
    measure = ("measure", {"question": {"what": "volume"}})
    yield Asks("previews, each in the place of the one before", [(*preview, None)] * 100, together=True)
    yield Asks("measurements, most of which may not wait", [(*measure, None)] * 100, together=True)
    yield Asks("cancels of all that may be", [("cancel", {"job": i}, None) for i in range(-50, 450)], together=True)
    for name, one in (("preview", preview), ("measure", measure), ("run", ("run", {"operation": "gaussian", "dataset": "ball", "parameters": {}})),
                      ("write", ("write", {"dataset": "ball", "path": "left.nrrd", "replace": True}))):
        yield Asks(f"{name}, and gone", [(*one, None)] * 20, together=True, leaves=True)


def fills(server):
    """A disk that is to be filled by what is made of little: each file is of 2.5 MB, and so is the room for each again."""
    write = [("write", {"dataset": "big", "path": f"big-{i}.nii"}) for i in range(20)]
    yield Asks("what is large", [(*edit(made("big", "pad", {"volume": "ball"}, all=60)), True)])
    yield Asks("files one after the other", [(*one, None) for one in write[:10]] + [("write", {"dataset": "big", "path": "last.nii"}, False)])
    yield Asks("files together", [(*one, False) for one in write[10:]], together=True)
    yield Asks("a scene of little", [("save", {"path": "little", "replace": True}, None), (*gone("big"), True)])
    there = [os.path.getsize(name) for name in os.listdir() if name.startswith("big-") or "part" in name]
    assert 2.5e6 < sum(there) <= ROOM, there


ROOM = 8 << 20
FAMILIES = (wrong_types, places, questions, recipes, storms, fills)
