"""Names inside files lead nowhere but below the header's folder (docs/reliability.md, R5).

Outside the folder lies a secret: samples that nothing else has. Headers of every format with data in other files name it in
fifty ways; where a format makes the name itself, or a folder is the volume, the file of that name is a link and the like. No
way may show its samples, with and without --safe; each ends at once, and is refused with one sentence.

Every header is first tried with an honest name: if that is not read, and read right, the test has failed.
"""
import json
import os
import socket
import struct
import tempfile

import hostile_files
from harness import Skip, main, ok, volvis

N = 4
SECRET = bytes([201 + i % 7 for i in range(N * N * N)])  # 201..207: no other file has such values
TOLD = "201.25"  # where a header is the secret: a number in it
HONEST = bytes(1 + i % 100 for i in range(N * N * N))


# What a header of a format looks like when its samples lie in the file of this name. ------------------------------------

NRRD = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nencoding: raw\ndata file: "
MHD = "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = "


def nrrd(name):
    return {"head.nhdr": f"{NRRD}{name}\n"}


def nrrd_list(name):
    return {"head.nhdr": f"{NRRD}LIST\n{name}\n"}


def nrrd_pattern(name):
    return {"head.nhdr": f"{NRRD}{numbered(name)} 3 3 1\n"}


def nrrd_slicer(name):
    """As 3D Slicer writes it."""
    return {"head.nhdr": "NRRD0004\n# Complete NRRD file format specification at:\n# http://teem.sourceforge.net/nrrd/format.html\ntype: uchar\n"
                         "dimension: 3\nspace: left-posterior-superior\nsizes: 4 4 4\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                         f"kinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\ndata file: {name}\n"}


def metaimage(name):
    return {"head.mhd": f"{MHD}{name}\n"}


def metaimage_list(name):
    return {"head.mhd": f"{MHD}LIST 3\n{name}\n"}


def metaimage_pattern(name):
    """A name for each slice: here there is one."""
    return {"head.mhd": f"{MHD}{numbered(name)} 3 3 1\n".replace("4 4 4", "4 16 1")}


def voreen(name):
    return {"head.dat": f"ObjectFileName: {name}\nResolution: 4 4 4\nSliceThickness: 1 1 1\nFormat: UCHAR\n"}


def openqvis(name):
    """Its model is told from the length of the data file: that is looked at by `info` already."""
    return {"head.dat": f"ObjectFileName:\t{name}\nTaggedFileName:\t---\nResolution:\t4 4 4\nSliceThickness:\t1 1 1\nFormat:\tUCHAR\nNbrTags:\t0\n"
                        "ObjectType:\tTEXTURE_VOLUME_OBJECT\nObjectModel:\tRGBA\nGridType:\tEQUIDISTANT\n"}


def opendx(name):
    return {"head.dx": "object 1 class gridpositions counts 4 4 4\norigin 0 0 0\ndelta 1 0 0\ndelta 0 1 0\ndelta 0 0 1\n"
                       "object 2 class gridconnections counts 4 4 4\n"
                       f"object 3 class array type unsigned byte rank 0 items 64 binary data file \"{name}\" 0\n"
                       "object \"f\" class field\ncomponent \"positions\" value 1\ncomponent \"connections\" value 2\ncomponent \"data\" value 3\nend\n"}


def opendx_general(name):
    return {"head.general": f"file = {name}\ngrid = 4 x 4 x 4\nformat = binary\nfield = v\ntype = unsigned byte\nstructure = scalar\nmajority = column\n"
                            "positions = 0, 1, 0, 1, 0, 1\nend\n"}


def vvh(name):
    return {"head.vvh": f"dims: 4 4 4\ntype: u8\ndata: {name}\n"}


def vvh_list(name):
    return {"head.vvh": f"dims: 4 4 4\ntype: u8\ndata:\n{name}\n"}


def vvh_pattern(name):
    return {"head.vvh": f"dims: 4 4 4\ntype: u8\ndata: {numbered(name)} 3 3 1\n"}


def numbered(name):
    """None where there is no number in it to count."""
    return name.replace("3", "%d") if name.count("3") == 1 else None


def pages(samples, description=b""):
    """A TIFF of one page for each slice."""
    slices = [samples[i:i + N * N] for i in range(0, len(samples), N * N)]
    text = description + b"\0"
    n_entries = 9 + (1 if description else 0)
    length = 2 + 12 * n_entries + 4 + N * N
    text_at = 8 + length * len(slices)
    out = b"II*\0" + struct.pack("<I", 8)
    for i, pixels in enumerate(slices):
        at = 8 + length * i
        entries = hostile_files.page(offset=at + length - N * N, n_bytes=N * N)
        if description:
            entries.append((270, 2, len(text), text_at))
        out += struct.pack("<H", n_entries) + b"".join(struct.pack("<HHII", *e) for e in sorted(entries))
        out += struct.pack("<I", at + length if i + 1 < len(slices) else 0) + pixels
    return out + text


OME = '<?xml version="1.0"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:0">%s</OME>'
PIXELS = ('<Image ID="Image:0"><Pixels ID="Pixels:0" PhysicalSizeX="%s" DimensionOrder="XYZCT" Type="uint8" SizeX="4" SizeY="4" SizeZ="4" SizeC="1" SizeT="1">'
          '<Channel ID="Channel:0:0"/>%s</Pixels></Image>')
HALF = HONEST[:32]


def ome_tiff(name):
    """Two planes are in it, two in the file that it names."""
    run = '<TiffData IFD="%d" FirstZ="%d" PlaneCount="2">%s</TiffData>'
    own = run % (0, 0, '<UUID FileName="head.ome.tif">urn:uuid:0</UUID>')
    other = run % (2, 2, f'<UUID FileName="{name}">urn:uuid:1</UUID>')
    return {"head.ome.tif": pages(HALF, (OME % (PIXELS % ("1", own + other))).encode("latin-1"))}


def ome_companion(name):
    """The planes are in it, what they are in the file that it names."""
    return {"head.ome.tif": pages(HONEST, (OME % f'<BinaryOnly MetadataFile="{name}" UUID="urn:uuid:9"/>').encode("latin-1"))}


def companion_of(samples):
    return (OME % (PIXELS % ("1" if samples == HONEST else TOLD, '<TiffData IFD="0" PlaneCount="4"/>'))).encode()


def bdv(name):
    return {"head.xml": '<?xml version="1.0"?><SpimData version="0.2"><BasePath type="relative">.</BasePath><SequenceDescription>'
                        f'<ImageLoader format="bdv.hdf5"><hdf5 type="relative">{name}</hdf5></ImageLoader><ViewSetups><ViewSetup><id>0</id><size>4 4 4</size>'
                        "</ViewSetup></ViewSetups><Timepoints type=\"range\"><first>0</first><last>0</last></Timepoints></SequenceDescription></SpimData>"}


def views_of(samples):
    import h5py
    import numpy
    with tempfile.NamedTemporaryFile(suffix=".h5") as made:
        with h5py.File(made.name, "w") as file:
            file["s00/resolutions"] = numpy.ones((1, 3))
            file["s00/subdivisions"] = numpy.full((1, 3), 4, "i4")
            file["t00000/s00/0/cells"] = numpy.frombuffer(samples, "u1").reshape(4, 4, 4).astype("i2")
        return made.read()


def zarr(name):
    """A group whose multiscale names its array; the secret is an array as well."""
    return {"head.zarr/.zgroup": '{"zarr_format": 2}', "head.zarr/.zattrs": json.dumps({"multiscales": [multiscale("0.4", name)]})}


def zarr3(name):
    attributes = {"ome": {"version": "0.5", "multiscales": [multiscale("0.5", name)]}}
    return {"head.zarr/zarr.json": json.dumps({"zarr_format": 3, "node_type": "group", "attributes": attributes})}


def multiscale(version, name):
    return {"version": version, "axes": [{"name": n, "type": "space"} for n in "zyx"],
            "datasets": [{"path": name, "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}]}


def array_of(samples):
    return {".zarray": json.dumps({"zarr_format": 2, "shape": [4, 4, 4], "chunks": [4, 4, 4], "dtype": "|u1", "compressor": None, "fill_value": 0, "order": "C",
                                   "filters": None}).encode(), "0.0.0": samples}


def array3_of(samples):
    return {"zarr.json": json.dumps({"zarr_format": 3, "node_type": "array", "shape": [4, 4, 4], "data_type": "uint8", "fill_value": 0, "attributes": {},
                                     "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [4, 4, 4]}},
                                     "chunk_key_encoding": {"name": "default"}, "codecs": [{"name": "bytes"}]}).encode(), "c/0/0/0": samples}


# What the named file is: end of its name, its bytes (a dictionary: a folder of files) from samples.
FORMS = {"plain": (".raw", bytes), "tiff": (".tif", pages), "companion": (".companion.ome", companion_of), "views": (".h5", views_of),
         "zarr": ("", array_of), "zarr3": ("", array3_of)}
FORMATS = [(nrrd, "plain"), (nrrd_list, "plain"), (nrrd_pattern, "plain"), (nrrd_slicer, "plain"), (metaimage, "plain"), (metaimage_list, "plain"),
           (metaimage_pattern, "plain"), (voreen, "plain"), (openqvis, "plain"), (opendx, "plain"), (opendx_general, "plain"), (vvh, "plain"),
           (vvh_list, "plain"), (vvh_pattern, "plain"), (ome_tiff, "tiff"), (ome_companion, "companion"), (bdv, "views"), (zarr, "zarr"), (zarr3, "zarr3")]


def put(path, samples, form):
    made = FORMS[form][1](samples)
    for name, data in made.items() if isinstance(made, dict) else [("", made)]:
        whole = os.path.join(path, name) if name else path
        os.makedirs(os.path.dirname(whole), exist_ok=True)
        with open(whole, "wb") as file:
            file.write(data)


def tricks(root, end):
    """Names that lead, or might lead, to root/secr3t from root/inside."""
    secret = f"secr3t{end}"
    up = f"../{secret}"
    yield "above", up
    yield "above, from below", f"below/../../{secret}"
    yield "above, from this", f"./../{secret}"
    yield "above twice", f"../../{os.path.basename(root)}/{secret}"
    yield "above, doubled slashes", f"..//{secret}"
    yield "above, after many", "below/" * 3 + "../" * 4 + secret
    yield "absolute", f"{root}/{secret}"
    yield "absolute with dots", f"{root}/inside/../{secret}"
    yield "absolute, two slashes", f"/{root}/{secret}"
    yield "link to it", f"l3nk{end}"
    yield "link to its folder", f"out/{secret}"
    yield "link to a link", f"again3{end}"
    yield "link that is absolute", f"absolut3{end}"
    yield "link that is absolute and stays", f"stays3{end}"
    yield "link in a folder", f"below/l3nk{end}"
    yield "link in a ring", f"ring3{end}"
    yield "/proc/self/root", f"/proc/self/root{root}/{secret}"
    yield "/proc/self/cwd", f"/proc/self/cwd/../{secret}"
    yield "link to /proc/self/root", f"magic{root}/{secret}"
    yield "a descriptor", "/dev/fd/0"
    yield "standard input", "/dev/stdin"
    yield "dash", "-"
    yield "device", "/dev/zero"
    yield "link to a device", "z3ro"
    yield "FIFO", "fif3"
    yield "link to a FIFO", "fif3link"
    yield "socket", "sock3t"
    yield "folder itself", "."
    yield "a folder", "below"
    yield "home", f"~/{secret}"
    yield "home of root", "~root/.profile"
    yield "variable", f"$HOME/{secret}"
    yield "command", f"`cat ../{secret}`"
    yield "pipe", f"|cat ../{secret}"
    yield "URL of a file", f"file://{root}/{secret}"
    yield "URL", f"http://127.0.0.1:9/{secret}"
    yield "URL of S3", f"s3://bucket/{secret}"
    yield "UNC", f"\\\\server\\share\\{secret}"
    yield "UNC with slashes", f"//server/share/{secret}"
    yield "drive letter", f"C:\\{secret}"
    yield "backslashes", f"..\\{secret}"
    yield "encoded slash", f"..%2f{secret}"
    yield "encoded dots", f"%2e%2e/{secret}"
    yield "encoded twice", f"..%252f{secret}"
    yield "overlong UTF-8", b"..\xc0\xaf".decode("latin-1") + secret
    yield "entity", f"..&#47;{secret}"
    yield "NUL", f"{up}\0.raw"
    yield "NUL before", f"hon3st{end}\0/../../{secret}"
    yield "trailing dots", f".../{secret}"
    yield "space before", f" ../{secret}"
    yield "4096 letters", "a" * 4096
    yield "deep", "below/" * 2000 + up
    yield "many ups", "../" * 2000 + f"{root.lstrip('/')}/{secret}"
    yield "nothing", ""
    yield "line end", f"hon3st{end}\n../{secret}"


def make_place(root, form):
    """Returns the folder that names in a header may lead below, and what to close."""
    end = FORMS[form][0]
    inside = os.path.join(root, "inside")
    if form.startswith("zarr"):
        inside = os.path.join(inside, "head.zarr")
    os.makedirs(os.path.join(inside, "below"))
    put(os.path.join(root, f"secr3t{end}"), SECRET, form)
    put(os.path.join(inside, f"hon3st{end}"), HONEST, form)
    above = os.path.relpath(root, inside)
    for name, target in {f"absolut3{end}": os.path.join(root, f"secr3t{end}"), f"stays3{end}": os.path.join(inside, f"hon3st{end}"),
                         f"l3nk{end}": f"{above}/secr3t{end}", f"again3{end}": f"l3nk{end}", f"below/l3nk{end}": f"../{above}/secr3t{end}", "out": above,
                         f"ring3{end}": f"ring3{end}", "magic": "/proc/self/root", "z3ro": "/dev/zero", "fif3link": f"{above}/fif3",
                         f"good3{end}": f"below/../hon3st{end}", f"below/back3{end}": f"../hon3st{end}"}.items():
        os.symlink(target, os.path.join(inside, name))
    os.mkfifo(os.path.join(inside, "fif3"))
    os.mkfifo(os.path.join(root, "fif3"))
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(os.path.join(inside, "sock3t"))
    return inside, listener


def write_head(folder, files):
    for name, text in files.items():
        os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
        with open(os.path.join(folder, name), "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode("latin-1"))
    return os.path.join(folder, next(iter(files)).split("/")[0])


def read(path, *words):
    """What the program makes of it: samples as bytes (None: refused), and what it said, at once and in one sentence."""
    for name in os.listdir("."):
        if name.endswith(".raw"):
            os.unlink(name)
    done = volvis("convert", path, "-o", "out.raw", "--output-format", "raw", "--overwrite", *words)  # it ends within a minute
    assert done.code in (0, 2, 3, 4, 7), f"exit {done.code}: {done.message}"
    made = b""
    for name in os.listdir("."):
        if name.endswith(".raw"):
            with open(name, "rb") as file:
                made += file.read()
    lines = [line for line in done.message.splitlines() if not line.startswith("volvis: warning: ")]
    assert len(lines) == (done.code not in (0, 7)), f"exit {done.code}, not one sentence: {done.message!r}"
    return made if done.code in (0, 7) else None, done


def tells_secret(path, *words):
    """For what is in a header and not among the samples."""
    done = volvis("info", path, *words)
    return TOLD in done.text + done.message


def samples_of(made, build):
    """In the order of the file, as bytes."""
    if build is opendx:  # the last axis goes fastest
        return bytes(made[N * N * (i % N) + N * (i // N % N) + i // N // N] for i in range(len(made)))
    return made[::2] if build is bdv else made  # of 16 bits


def check_honest(build, form, inside):
    """Names that are good, and links that stay below the folder, are read and read right."""
    end = FORMS[form][0]
    folder = os.path.dirname(inside) if form.startswith("zarr") else inside
    for name in (f"hon3st{end}", f"good3{end}", f"below/back3{end}", f"./hon3st{end}"):
        files = build(name)
        head = write_head(folder, files)
        made, done = read(head)
        assert made is not None, f"{build.__name__}: the honest {name} is not read: {done.message}"
        assert samples_of(made, build) == HONEST, f"{build.__name__}: the honest {name} is read wrong: {made[:16]}"
        made, done = read(head, "--safe")
        if name.endswith(f"hon3st{end}") or form == "plain":
            assert made and samples_of(made, build) == HONEST, f"{build.__name__}: the honest {name} is not read with --safe: {done.message}"
    return head


def may_be_read(what, build):
    """What is a good name after all, as the format reads it; no secret is shown in any case."""
    if what == "nothing":
        return build in (ome_tiff, ome_companion, vvh_list, nrrd_list, metaimage_list)
    if what == "NUL":
        return build is ome_companion  # the text ends there: a TIFF without OME-XML
    return what in ("NUL before", "line end", "space before")


def try_trick(build, form, head, what, *words):
    made, done = read(head, *words)
    where = f"{build.__name__}: {what} {words}"
    assert not set(made or b"") & set(range(201, 208)), f"{where}: the secret is shown"
    assert form != "companion" or not tells_secret(head, *words), f"{where}: the secret is told"
    if build is ome_tiff and made is not None:  # half of its planes are its own
        assert done.code == 7 and made == HALF + bytes(32), f"{where}: {made}"
    elif made is not None and not may_be_read(what, build):
        raise AssertionError(f"{where}: was read as something: {made[:16]}")
    elif made is not None:
        assert set(made) <= set(HONEST) | {0}, f"{where}: {made}"


def try_format(build, form):
    """How many tricks were tried."""
    with tempfile.TemporaryDirectory(prefix="volvis-paths-") as root:
        inside, listener = make_place(root, form)
        folder = os.path.dirname(inside) if form.startswith("zarr") else inside
        end = FORMS[form][0]
        n = 0
        head = check_honest(build, form, inside)
        for what, name in tricks(root, end):
            if numbered(name) is None and build.__name__.endswith("pattern"):
                continue
            write_head(folder, build(name))
            for words in ([], ["--safe"]) if n % 5 == 0 else ([],):
                try_trick(build, form, head, what, *words)
            n += 1
        listener.close()
        # by hand it is allowed
        write_head(folder, build(f"../secr3t{end}"))
        made, done = read(head, "--allow-outside")
        if form == "companion":
            assert tells_secret(head, "--allow-outside"), f"{build.__name__}: --allow-outside allows nothing"
        else:
            assert form.startswith("zarr") or set(made or b"") & set(range(201, 208)), f"{build.__name__}: --allow-outside allows nothing: {done.message}"
        return n


def not_in_this_build(form):
    """Libraries that a build may lack; that of a format which is there must read the honest file."""
    built = volvis("version").text + volvis("formats").text
    try:
        import h5py
        import numpy
        del h5py, numpy
    except ImportError:
        return form == "views"
    return (form == "views" and "hdf5" not in built.lower()) or (form in ("tiff", "companion", "views") and "expat" not in built.lower())


def test_no_name_in_a_file_leads_out_of_its_folder():
    tried = {build.__name__: None if not_in_this_build(form) else try_format(build, form) for build, form in FORMATS}
    print("; ".join(f"{name}: {n} tricks" if n else f"{name}: not read by this build" for name, n in tried.items()))
    assert all(n is None or n >= (8 if name.endswith("pattern") else 50) for name, n in tried.items())


# Names that a format makes by itself: the file of that name is the trick. -------------------------------------------------

def analyze(magic):
    """A header of 348 bytes and the place of its samples: head.hdr, head.img."""
    return hostile_files.nifti1([3, N, N, N], 2, 8, offset=0.0, n=348, magic=magic)


def bad_places(root, inside, end):
    """What may stand where a file is expected: made(path)."""
    secret = os.path.join(root, f"secr3t{end}")
    yield "a link to it", lambda path: os.symlink(os.path.relpath(secret, os.path.dirname(path)), path)
    yield "an absolute link to it", lambda path: os.symlink(secret, path)
    yield "an absolute link that stays", lambda path: os.symlink(os.path.join(inside, f"hon3st{end}"), path)
    yield "a link to a link", lambda path: os.symlink(f"l3nk{end}", path)
    yield "a link through a folder", lambda path: os.symlink(f"out/secr3t{end}", path)
    yield "a link to /proc", lambda path: os.symlink(f"/proc/self/root{secret}", path)
    yield "a link to a device", lambda path: os.symlink("/dev/zero", path)
    yield "a link to a descriptor", lambda path: os.symlink("/dev/stdin", path)
    yield "a link to a FIFO", lambda path: os.symlink("../fif3", path)
    yield "a link to itself", lambda path: os.symlink(os.path.basename(path), path)
    yield "a link to nothing", lambda path: os.symlink("nothing", path)
    yield "a FIFO", os.mkfifo
    yield "a folder", os.mkdir


def remove(path):
    if os.path.isdir(path) and not os.path.islink(path):
        os.rmdir(path)
    elif os.path.lexists(path):
        os.unlink(path)


def test_the_second_file_of_a_pair_is_one_of_its_folder():
    """NIfTI and Analyze: the name is made from the header's."""
    for magic in (b"ni1\0", bytes(4)):
        with tempfile.TemporaryDirectory(prefix="volvis-paths-") as root:
            inside, listener = make_place(root, "plain")
            head, image = os.path.join(inside, "head.hdr"), os.path.join(inside, "head.img")
            with open(head, "wb") as file:
                file.write(analyze(magic))
            os.symlink("hon3st.raw", image)
            for path in (head, image) if magic[0] else (head,):
                made, done = read(path)
                assert made == HONEST, f"{magic}: a link that stays below the folder: {done.message}"
            remove(image)
            for n, (what, make) in enumerate(bad_places(root, inside, ".raw")):
                make(image)
                for words in ([], ["--safe"]) if n % 4 == 0 else ([],):
                    made, done = read(head, *words)
                    assert made is None, f"{magic}: {what} {words}: was read as {made[:16]}"
                remove(image)
            listener.close()


def slice_of(kind, samples, k):
    pixels = samples[16 * k:16 * k + 16]
    if kind == "tif":
        return pages(pixels)
    body = hostile_files.image_elements(pixels=pixels)
    number, place = hostile_files.element(0x20, 0x13, b"IS", b"%d " % (k + 1)), b"0\\0\\%d " % k
    series, rest = body.split(struct.pack("<HH", 0x28, 2), 1)
    axes = b"1\\0\\0\\0\\1\\0 "
    more = number + hostile_files.element(0x20, 0x32, b"DS", place) + hostile_files.element(0x20, 0x37, b"DS", axes)
    return hostile_files.dicom(series + more + struct.pack("<HH", 0x28, 2) + rest)


def test_the_files_of_a_folder_are_those_in_it():
    """Folders of slices, of which the second is something else: it is missing or all is refused, the secret is not shown."""
    for kind in ("tif", "dcm"):
        with tempfile.TemporaryDirectory(prefix="volvis-paths-") as root:
            inside, listener = make_place(root, "plain")
            listener.close()
            scan = os.path.join(root, "scan")
            os.mkdir(scan)
            for k in range(4):
                with open(os.path.join(scan, f"s{k}.{kind}"), "wb") as file:
                    file.write(slice_of(kind, HONEST, k))
            with open(os.path.join(root, f"secr3t.{kind}"), "wb") as file:
                file.write(slice_of(kind, SECRET, 1))
            made, done = read(scan)
            assert made == HONEST, f"{kind}: the honest folder: {done.message}"
            second = os.path.join(scan, f"s1.{kind}")
            os.mkdir(os.path.join(scan, "below"))
            os.rename(second, os.path.join(scan, "below", "kept"))
            for n, (what, make) in enumerate(bad_places(root, scan, f".{kind}")):
                os.symlink("..", os.path.join(scan, "out"))
                make(second)
                for words in ([], ["--safe"]) if n % 4 == 0 else ([],):
                    made, done = read(scan, *words)
                    assert not set(made or b"") & set(range(201, 208)), f"{kind}: {what} {words}: the secret is shown"
                remove(second)
                remove(os.path.join(scan, "out"))


def test_pieces_of_an_array_are_files_of_it():
    """Zarr: a chunk, its metadata or a folder that is a link and the like."""
    for form, chunk, about in (("zarr", "0.0.0", ".zarray"), ("zarr3", "c/0/0/0", "zarr.json")):
        with tempfile.TemporaryDirectory(prefix="volvis-paths-") as root:
            array = os.path.join(root, "scan.zarr")
            put(array, HONEST, form)
            put(os.path.join(root, "other"), SECRET, form)
            os.mkfifo(os.path.join(root, "fif3"))
            for name in (chunk, about):
                with open(os.path.join(root, "other", name), "rb") as file, open(os.path.join(root, "secr3t"), "wb") as secret:
                    secret.write(file.read())
                path = os.path.join(array, name)
                made, done = read(array)
                assert made == HONEST, f"{form}: the honest array: {done.message}"
                os.rename(path, path + ".kept")
                for n, (what, make) in enumerate(bad_places(root, array, "")):
                    make(path)
                    for words in ([], ["--safe"]) if n % 4 == 0 else ([],):
                        made, done = read(array, *words)
                        assert not set(made or b"") & set(range(201, 208)), f"{form}: {name} is {what} {words}: the secret is shown"
                    remove(path)
                os.rename(path + ".kept", path)


# HDF5 has its own ways out: the library opens other files by itself. ------------------------------------------------------

def hdf5_ways_out(folder, secret):
    import h5py
    import numpy as np
    doubles = np.arange(64.0).reshape(4, 4, 4)

    def made(name, build):
        with h5py.File(f"{folder}/{name}", "w", libver="latest") as file:
            build(file)
        return name

    def view(file, source):
        layout = h5py.VirtualLayout((4, 4, 4), "u1")
        layout[:] = h5py.VirtualSource(source, "v", (4, 4, 4))
        file.create_virtual_dataset("v", layout)

    def minc(file, ends=None, places=None):
        for axis in "xyz":
            options = {"shape": (4,), "dtype": "f8", "external": [(places, 0, 32)]} if places else {"data": 0.0}
            at = file.create_dataset(f"minc-2.0/dimensions/{axis}space", **options)
            at.attrs.update({"start": 0.0, "step": 1.0, "spacing": np.bytes_("irregular" if places else "regular__")})
        image = file.create_dataset("minc-2.0/image/0/image", data=np.frombuffer(HONEST, "u1").reshape(4, 4, 4))
        image.attrs["dimorder"] = np.bytes_("zspace,yspace,xspace")
        for name, value in (("min", 0.0), ("max", 255.0)):
            options = {"shape": (4,), "dtype": "f8", "external": [(ends, 0, 32)]} if ends else {"data": value}
            file.create_dataset(f"minc-2.0/image/0/image-{name}", **options)

    def views(file, rows):
        options = {"shape": (1, 3), "dtype": "f8", "external": [(rows, 0, 24)]} if rows else {"data": np.ones((1, 3))}
        file.create_dataset("s00/resolutions", **options)
        file["t00000/s00/0/cells"] = np.frombuffer(HONEST, "u1").reshape(4, 4, 4).astype("i2")
        file["t00000/s00/1/cells"] = np.ones((2, 2, 2), "i2")

    def netcdf(file, places):
        scale = file.create_dataset("x", shape=(4,), dtype="f8", external=[(places, 0, 32)])
        scale.make_scale("x")
        data = file.create_dataset("v", data=np.frombuffer(HONEST, "u1").reshape(4, 4, 4))
        data.dims[2].attach_scale(scale)
        file.attrs["_NCProperties"] = np.bytes_("version=2,netcdf=4.7.4,hdf5=1.10.8")

    yield made("external_link.h5", lambda f: f.__setitem__("v", h5py.ExternalLink(secret, "/v")))
    yield made("external_samples.h5", lambda f: f.create_dataset("v", (4, 4, 4), "u1", external=[(secret, 0, 64)]))
    yield made("view.h5", lambda f: view(f, secret))
    yield made("ends.mnc", lambda f: minc(f, ends=secret))
    yield made("places.mnc", lambda f: minc(f, places=secret))
    yield made("rows.h5", lambda f: views(f, secret))
    yield made("places.nc", lambda f: netcdf(f, secret))
    with h5py.File(f"{folder}/honest.mnc", "w") as file:
        minc(file)
    del doubles


def test_hdf5_opens_no_other_file():
    """External links, external samples, virtual data sets: of the samples, and of the tables beside them. None is opened:
    a secret shows in no number, a FIFO is not waited for."""
    try:
        import h5py
        del h5py
    except ImportError:
        raise Skip("there is no h5py to make such files")
    if not_in_this_build("views"):
        raise Skip("this build has no HDF5")
    secret = os.path.abspath("secret.bin")
    with open(secret, "wb") as file:
        file.write(struct.pack("<8d", 20123.25, 20124.5, 20125.75, 20127, 1, 1, 1, 1))
    os.mkdir("inside")
    beside = "beside.bin"  # also relative names are of other files
    os.link(secret, f"inside/{beside}")
    os.mkfifo("fifo")
    for target in (secret, os.path.abspath("fifo"), beside, "/dev/zero"):
        for name in hdf5_ways_out("inside", target):
            for words in ([], ["--safe"]):
                done = volvis("info", "--stats", "--json", f"inside/{name}", *words)
                assert done.code in (0, 2, 3, 4), f"{name} to {target} {words}: exit {done.code}: {done.message}"
                assert "2012" not in done.text + done.message, f"{name} to {target} {words}: the secret is told: {done.text}{done.message}"
    ok("info", "--stats", "inside/honest.mnc")


def test_xml_names_no_other_file():
    """Entities: of a file, of an address, that grow."""
    with open("secret.txt", "w") as file:
        file.write("201 202 203 204")
    entities = {"file": '<!ENTITY e SYSTEM "secret.txt">', "absolute": f'<!ENTITY e SYSTEM "file://{os.path.abspath("secret.txt")}">',
                "parameter": '<!ENTITY % p SYSTEM "secret.txt"> %p; <!ENTITY e "9">', "address": '<!ENTITY e SYSTEM "http://127.0.0.1:9/">',
                "growing": '<!ENTITY a "1 1 1 1 1 1 1 1 1 1">' + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdfghi", "bcdfghij"))
                + '<!ENTITY e "&j;">'}
    vti = ('<VTKFile type="ImageData" byte_order="LittleEndian"><ImageData WholeExtent="0 1 0 1 0 0"><Piece Extent="0 1 0 1 0 0"><PointData Scalars="a">'
           '<DataArray type="UInt8" Name="a" format="ascii">%s</DataArray></PointData></Piece></ImageData></VTKFile>')
    heads = {"a.vti": vti % "&e;", "a.xml": bdv("&e;")["head.xml"].split("?>")[1],
             "a.ome.tif": (OME % (PIXELS % ("&e;", '<TiffData IFD="0" PlaneCount="4"/>'))).split("?>")[1]}
    with open("a.vti", "w") as file:
        file.write(vti % "1 2 3 4")
    assert not_in_this_build("tiff") or read("a.vti")[0] == bytes([1, 2, 3, 4])
    for what, entity in entities.items():
        for name, body in heads.items():
            text = f'<?xml version="1.0"?><!DOCTYPE x [{entity}]>{body}'.encode()
            with open(name, "wb") as file:
                file.write(pages(HONEST, text) if name.endswith("tif") else text)
            done = volvis("info", "--stats", name)
            assert done.code in ((0, 2, 3) if name.endswith("tif") else (2, 3)), f"{what} in {name}: exit {done.code}: {done.message}"
            assert "201" not in done.text + done.message, f"{what} in {name}: {done.text}{done.message}"


def test_a_hard_link_is_a_file_of_its_folder():
    """The system does not tell whether a file has another name elsewhere; who may link may read."""
    os.mkdir("inside")
    with open("secret.raw", "wb") as file:
        file.write(SECRET)
    os.link("secret.raw", "inside/hard.raw")
    write_head("inside", nrrd("hard.raw"))
    ok("info", "inside/head.nhdr")


def test_a_header_behind_a_link_is_one_of_the_folder_of_the_link():
    """What the user names may be a link: data files are looked for beside the name that was given, not where it leads."""
    for folder, samples in (("there", SECRET), ("here", HONEST)):
        os.mkdir(folder)
        with open(os.path.join(folder, "data.raw"), "wb") as file:
            file.write(samples)
    write_head("there", nrrd("data.raw"))
    os.symlink("../there/head.nhdr", "here/link.nhdr")
    made, done = read("here/link.nhdr")
    assert made == HONEST, done.message


if __name__ == "__main__":
    main()
