"""GDCM is loaded when a file needs it: by the program, by the import program, by the library, wherever they were copied."""
import gzip
import os
import shutil
import subprocess
from harness import VOLVIS, Skip, environment, main, ok, sanitized, says, write_ball
from test_dicom import as_npy, image, need, pack, save, smooth

BUILD = os.path.dirname(VOLVIS)
MODULE = "volvis-gdcm.so"
SENTENCE = "is packed as lossy JPEG, JPEG-LS or JPEG 2000, which needs volvis-gdcm.so"


def need_module():
    need()
    if not os.path.exists(os.path.join(BUILD, MODULE)):
        raise Skip("built without GDCM")


def packed(path):
    save(image(smooth("|u1")[0], ImagePositionPatient=[0, 0, 0], ImageOrientationPatient=[1, 0, 0, 0, 1, 0]), "plain.dcm")
    pack("plain.dcm", path, "JPEG2000Lossless")
    return path


def tree(folder):
    """What `make install` makes of the programs, the library and the module."""
    for name, place in (("volvis", "bin"), ("volvis-import", "libexec/volvis"), (MODULE, "libexec/volvis"),
                        ("src/libvolvis.so.0", "lib/x86_64-linux-gnu")):
        os.makedirs(f"{folder}/{place}", exist_ok=True)
        shutil.copy(os.path.join(BUILD, name), f"{folder}/{place}")
    return f"{folder}/libexec/volvis/{MODULE}"


def run(folder, *words):
    done = subprocess.run([f"{folder}/bin/volvis", *words], env=environment(), capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_nothing_else_is_linked_with_it():
    need_module()
    for name in ("volvis", "volvis-import", "src/libvolvis.so.0"):
        linked = subprocess.run(["ldd", os.path.join(BUILD, name)], capture_output=True, text=True, check=True).stdout
        assert "libc.so" in linked and "gdcm" not in linked, name


def test_the_import_program_has_it_however_dicom_comes():
    need_module()
    packed("l.dcm")
    os.mkdir("folder")
    shutil.copy("l.dcm", "folder/1")
    shutil.copy("l.dcm", "noname")
    shutil.copy("l.dcm", "named.nrrd")
    with open("l.dcm", "rb") as file:
        whole = file.read()
    for name in ("l.dcm.gz", "coded", "coded.gz", "coded.nrrd", "coded.nii.gz"):
        with gzip.open(name, "wb") as file:
            file.write(whole)
    want = as_npy("l.dcm")
    for path in ("l.dcm", "folder", "noname", "named.nrrd", "l.dcm.gz", "coded", "coded.gz", "coded.nrrd", "coded.nii.gz",
                 "folder/1", "-"):
        ok("convert", path, "-o", "safe.npy", "--stored", "--safe", "--overwrite", stdin=whole if path == "-" else b"")
        with open("safe.npy", "rb") as safe, open("read.npy", "rb") as plain:
            assert safe.read()[-want.size:] == plain.read()[-want.size:], path


def test_a_copied_tree_has_it():
    need_module()
    packed("l.dcm")
    module = tree("tree")
    for safe in ("--safe", "--no-safe"):
        code, said = run("tree", "info", "l.dcm", safe)
        assert code == 0, said
        assert run("tree", "convert", "l.dcm", "-o", "a.npy", safe, "--overwrite")[0] == 0
    code, said = run("tree", "version", "--json")
    assert code == 0 and '"GDCM":null' not in said.replace(" ", ""), said
    os.rename(module, "away")
    if os.path.exists(os.path.join("/usr/local/libexec/volvis", MODULE)):
        raise Skip("an installed VolVis has it")
    for safe in ("--safe", "--no-safe"):
        code, said = run("tree", "info", "l.dcm", safe)
        assert code == 3 and said.strip().count("\n") == 0, said
        says(said, SENTENCE, "there is no volvis-gdcm.so beside the program", "install VolVis again")
    says(" ".join(run("tree", "version")[1].split()), "GDCM (not installed)")
    says(" ".join(run("tree", "doctor")[1].split()), "MISSING: no lossy DICOM: there is no volvis-gdcm.so", "install VolVis again")


def test_what_is_no_module_is_one_sentence():
    need_module()
    packed("l.dcm")
    module = tree("tree")
    write_ball()
    linked = subprocess.run(["ldd", VOLVIS], capture_output=True, text=True, check=True).stdout.split()
    shutil.copy(next(word for word in linked if word.startswith("/") and "libz.so" in word), module)  # it has no table
    code, said = run("tree", "info", "l.dcm")
    assert code == 3, said
    says(said, SENTENCE, "cannot be loaded")
    with open(module, "w", encoding="utf-8") as file:
        file.write("no library")
    for safe in ("--safe", "--no-safe"):
        code, said = run("tree", "info", "l.dcm", safe)
        assert code == 3 and said.strip().count("\n") == 0, said
        says(said, SENTENCE, "cannot be loaded", MODULE)
        assert run("tree", "info", "head.nrrd", safe)[0] == 0
        assert run("tree", "info", "plain.dcm", safe)[0] == 0


def test_the_library_has_it_in_a_program_that_lies_elsewhere():
    need_module()
    if sanitized():
        raise Skip("Python has no sanitizer")
    path = packed("l.dcm")
    tree("tree")
    script = f"""if True:
        import ctypes
        volvis = ctypes.CDLL("tree/lib/x86_64-linux-gnu/libvolvis.so.0")
        job, file = ctypes.c_void_p(), ctypes.c_void_p()
        assert volvis.vv_job_new(ctypes.byref(job), None, None, None) == 0
        assert volvis.vv_file_open(ctypes.byref(file), b"{path}", None, job) == 0
        assert "tree/libexec/volvis/{MODULE}" in open("/proc/self/maps").read()"""
    subprocess.run(["/usr/bin/python3", "-c", script], check=True)


if __name__ == "__main__":
    main()
