"""Series of volumes and volumes of series, against nibabel and NumPy."""
import glob
import os
import struct

from harness import Skip, fails, main, ok, says

try:
    import nibabel
    import numpy as np
except ImportError:
    np = None


def need():
    if np is None:
        raise Skip("nibabel is not there")


def volume(name, seed, shape=(9, 7, 5), frames=0, kind="i2", step=0.0):
    data = np.random.default_rng(seed).integers(0, 100, shape + ((frames,) if frames else ())).astype(kind)
    image = nibabel.Nifti1Image(data, np.array([[-2, 0, 0, 10], [0, 2, 0, -20], [0, 0, 3, 5], [0, 0, 0, 1.0]]))
    image.header.set_xyzt_units("mm", "sec")
    if frames:
        image.header["pixdim"][4] = step
    nibabel.save(image, name)
    return data


def test_volumes_and_series_are_joined_as_nibabel_concatenates_them():
    need()
    parts = [volume(f"v{i}.nii", i) for i in range(3)] + [volume("s.nii.gz", 9, frames=4, step=3)]
    ok("join", "v0.nii", "v1.nii", "v2.nii", "-o", "three.nii.gz", "--period", "2.5", "--period-unit", "s")
    got, want = nibabel.load("three.nii.gz"), nibabel.concat_images([f"v{i}.nii" for i in range(3)])
    assert np.array_equal(np.asanyarray(got.dataobj), np.asanyarray(want.dataobj)) and np.allclose(got.affine, want.affine)
    assert got.header["pixdim"][4] == 2.5 and got.header.get_xyzt_units() == ("mm", "sec")
    ok("join", "v1.nii", "s.nii.gz", "s.nii.gz@2", "v0.nii", "-o", "mixed.nii")
    got = np.asanyarray(nibabel.load("mixed.nii").dataobj)
    want = np.concatenate([parts[1][..., None], parts[3], parts[3][..., 2:3], parts[0][..., None]], 3)
    assert got.dtype == want.dtype and np.array_equal(got, want)


def test_a_folder_and_a_pattern_are_joined_with_what_follows():
    need()
    os.mkdir("run")
    parts = [volume(f"run/t_{i}.nii", i) for i in range(4)]
    last = volume("last.nii", 8)
    for words in (["run/"], ["run/t_{t}.nii"]):
        ok("join", *words, "last.nii", "-o", "all.nii", "--overwrite")
        got = np.asanyarray(nibabel.load("all.nii").dataobj)
        assert np.array_equal(got, np.stack([*parts, last], 3)), words


def test_splitting_gives_the_steps_with_what_the_series_says():
    need()
    data = volume("s.nii.gz", 9, frames=12, step=3)
    ok("split", "s.nii.gz", "-o", "step-%03d.nii.gz")
    names = sorted(glob.glob("step-*"))
    assert names == [f"step-{i:03}.nii.gz" for i in range(12)], names
    for i, (name, one) in enumerate(zip(names, nibabel.four_to_three(nibabel.load("s.nii.gz")))):
        got = nibabel.load(name)
        assert got.shape == (9, 7, 5) and np.array_equal(np.asanyarray(got.dataobj), data[..., i]), name
        assert np.allclose(got.affine, one.affine) and got.header.get_xyzt_units()[0] == "mm"
    said = ok("split", "s.nii.gz", "-o", "n%d.nrrd", "--dry-run", "--json").json
    assert said["outputs"] == [f"n{i}.nrrd" for i in range(12)] and not glob.glob("n*.nrrd")
    ok("join", *names, "-o", "back.nii.gz", "--period", "3", "--period-unit", "s")
    assert np.array_equal(np.asanyarray(nibabel.load("back.nii.gz").dataobj), data)
    for suffix in "nii", "nrrd":  # the period comes back
        ok("split", "back.nii.gz", "-o", f"p%d.{suffix}")
        ok("join", f"p0.{suffix}", f"p1.{suffix}", "-o", f"again.{suffix}")
        said = ok("info", f"again.{suffix}", "--json").json
        assert (said["frame_step"], said["frame_unit"], said["frames"]) == (3, "s", 2), said
    says(fails(2, "split", "s.nii.gz", "-o", "x.nii"), "step-%03d.nii.gz")
    says(fails(2, "split", "s.nii.gz", "-o", "%d-%d.nii"), "stands once")
    says(fails(2, "split", "s.nii.gz@3", "-o", "x%d.nii"), "'volvis convert' writes one")


def test_what_does_not_fit_is_refused_with_both_values():
    need()
    volume("a.nii", 1)
    volume("small.nii", 2, shape=(9, 7, 4))
    volume("u.nii", 2, kind="u1")
    says(fails(2, "join", "a.nii", "small.nii", "-o", "x.nii"), "expected 9 x 7 x 5", "found 9 x 7 x 4")
    says(fails(2, "join", "pre=a.nii", "post=u.nii", "-o", "x.nii"), "the volume 'post': expected type i16", "found u8")
    with open("a.nii", "rb") as file:
        scaled = bytearray(file.read())
    scaled[112:120] = struct.pack("<2f", 0.5, 1)
    with open("scaled.nii", "wb") as file:
        file.write(scaled)
    says(fails(2, "join", "a.nii", "scaled.nii", "-o", "x.nii"), "1 * stored + 0", "0.5 * stored + 1", "--type f32")
    says(fails(2, "join", "a.nii", "a.nii", "-o", "x.nii", "--period-unit", "s"), "give it with")
    says(fails(2, "join", "a.nii", "-o", "x.nii"), "join needs one more input")
    assert not os.path.exists("x.nii")


def test_what_memory_does_not_hold_is_joined_slab_by_slab():
    need()
    for i in range(3):
        volume(f"l{i}.nii", i, shape=(120, 120, 121))
    names = [f"l{i}.nii" for i in range(3)]
    ok("join", *names, "-o", "whole.nrrd")
    said = ok("join", *names, "-o", "parts.nrrd", "--memory", "14M", "--json").json
    assert said["streamed"] and open("whole.nrrd", "rb").read() == open("parts.nrrd", "rb").read()


def test_a_scene_remembers_what_was_joined_and_joins_it_for_its_pictures():
    need()
    parts = [volume("v0.nii", 0), volume("s.nii", 1, frames=2, step=1), volume("v1.nii", 2)]
    ok("pipe", "v0.nii", "join s.nii v1.nii --period 2 --period-unit s", "-o", "p.vv.json")
    for step, want in enumerate([parts[0], parts[1][..., 0], parts[1][..., 1], parts[2]]):
        ok("convert", "p.vv.json", "--frame", str(step), "-o", "o.npy", "--overwrite")
        assert np.array_equal(np.load("o.npy").T.squeeze(), want), step
    ok("render", "p.vv.json", "-o", "p.png", "--size", "32x32", "--frame", "3")
    says(fails(2, "convert", "p.vv.json", "--frame", "4", "-o", "o.npy", "--overwrite"), "has 4")


main()
