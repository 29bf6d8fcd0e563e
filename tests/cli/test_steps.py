"""Time steps in files of their own: folders, patterns and collections of ParaView's, told from what numpy wrote."""
import os
import shutil
import nibabel
import numpy
import vtk
from vtk.util import numpy_support
from harness import fails, main, ok, png_pixels, says, volvis, write_nrrd

DIMS = (4, 5, 6)  # z, y, x


def volume(step):
    return (numpy.arange(120).reshape(DIMS) + 1000 * step).astype("f4")


def write_vti(path, samples, time=None, spacing=(1, 2, 3)):
    image = vtk.vtkImageData()
    image.SetDimensions(samples.shape[::-1])
    image.SetSpacing(spacing)
    for name, values in (("pressure", samples), ("heat", -samples)):
        array = numpy_support.numpy_to_vtk(values.ravel(), deep=1)
        array.SetName(name)
        image.GetPointData().AddArray(array)
    if time is not None:
        times = vtk.vtkDoubleArray()
        times.SetName("TimeValue")
        times.InsertNextValue(time)
        image.GetFieldData().AddArray(times)
    writer = vtk.vtkXMLImageDataWriter()
    writer.SetFileName(path)
    writer.SetInputData(image)
    writer.Write()


def write_nifti(path, samples, offset=0, slope=None):
    image = nibabel.Nifti1Image(samples.transpose(2, 1, 0), numpy.diag([1, 2, 3, 1]))
    image.header.set_xyzt_units("mm", "sec")
    image.header["toffset"] = offset
    image.header["descrip"] = b"perfusion"
    nibabel.save(image, path)


def folder(name):
    shutil.rmtree(name, ignore_errors=True)
    os.mkdir(name)
    return name


def steps_of(word, *options):
    """All samples of a data set, (t, z, y, x), as numpy reads what convert made of it."""
    ok("convert", word, "-o", "all.npy", "--overwrite", *options)
    return numpy.load("all.npy")


def test_volumes_whose_names_differ_in_a_number_are_time_steps_in_its_order():
    name = folder("jet")
    for step in (1, 2, 10):
        write_vti(f"{name}/jet_{step}.vti", volume(step))
    with open(f"{name}/README.txt", "w") as file:
        file.write("what this is")
    assert (steps_of(name) == numpy.stack([volume(t) for t in (1, 2, 10)])).all()
    assert (steps_of(name + ":heat") == -numpy.stack([volume(t) for t in (1, 2, 10)])).all()
    assert (steps_of(name + "@2") == volume(10)).all()
    assert (steps_of(name, "--frame", "1") == volume(2)).all()
    seen = ok("info", name, "--json").json
    assert (seen["format"], seen["frames"], seen["dims"], seen["spacing"]) == ("steps", 3, [6, 5, 4], [1, 2, 3]), seen
    says(seen["warnings"][0], "'jet_10.vti' follows 'jet_2.vti', 7 in all seem to be missing")
    said = volvis("info", name + "@3")
    assert said.code == 2, said.message
    says(said.message, "no time step 3", "has 3")


def test_a_step_is_rendered_and_measured_as_its_file_is():
    name = folder("run")
    for step in range(3):
        write_nrrd(f"{name}/t{step:02}.nrrd", (8, 8, 8), lambda x, y, z: 30 * step + 8 * x)
    small = ["--size", "24x24", "--overwrite"]
    ok("render", f"{name}@2", "-o", "a.png", *small)
    ok("render", f"{name}/t02.nrrd", "-o", "b.png", *small)
    assert png_pixels("a.png") == png_pixels("b.png")
    ok("render", f"{name}@1", "-o", "c.png", "--save-scene", "c.vv.json", *small)
    ok("render", "c.vv.json", "-o", "d.png", *small)
    assert png_pixels("c.png") == png_pixels("d.png")
    ok("gaussian", name, "-o", "smooth.npy", "--sigma", "1", "--overwrite")
    ok("gaussian", f"{name}/t01.nrrd", "-o", "one.npy", "--sigma", "1", "--overwrite")
    assert (numpy.load("smooth.npy")[1] == numpy.load("one.npy")).all()


def test_times_come_from_the_files():
    name = folder("timed")
    for step in range(4):
        write_nifti(f"{name}/pet_{step:03}.nii.gz", volume(step), offset=2.5 * step)
    seen = ok("info", name, "--json").json
    assert (seen["frames"], seen["frame_step"], seen["frame_unit"]) == (4, 2.5, "s"), seen
    ok("convert", name, "-o", "pet.nii.gz", "--overwrite")
    image = nibabel.load("pet.nii.gz")
    assert image.header["pixdim"][4] == 2.5 and bytes(image.header["descrip"]).startswith(b"perfusion"), image.header
    assert (numpy.asarray(image.dataobj) == numpy.stack([volume(t) for t in range(4)]).transpose(3, 2, 1, 0)).all()
    name = folder("uneven")
    for step, time in enumerate((0, 1, 5)):
        write_vti(f"{name}/a{step}.vti", volume(step), time)
    seen = ok("info", name, "--json").json
    assert seen["frame_step"] == 0 and seen["metadata"]["times"] == "0, 1, 5", seen
    says(seen["warnings"][0], "uneven, from 0 to 5")
    name = folder("backwards")
    for step, time in enumerate((2, 1)):
        write_vti(f"{name}/a{step}.vti", volume(step), time)
    says(ok("info", name, "--json").json["warnings"][0], "'a1.vti' is not later than 'a0.vti'")


def write_collection(name, rows):
    with open(name, "w") as file:
        sets = "".join(f'<DataSet timestep="{time}" group="" part="0" file="{path}"/>' for time, path in rows)
        file.write(f'<?xml version="1.0"?><VTKFile type="Collection" version="0.1"><Collection>{sets}</Collection></VTKFile>')


def test_a_collection_of_paraview_says_files_and_times():
    name = folder("pvd")
    for step in range(3):
        write_vti(f"{name}/a{step}.vti", volume(step))
    write_collection(f"{name}/a.pvd", [(0.25 * t, f"a{2 - t}.vti") for t in range(3)])
    seen = ok("info", f"{name}/a.pvd", "--json").json
    assert (seen["format"], seen["frames"], seen["frame_step"]) == ("pvd", 3, 0.25), seen
    assert (steps_of(f"{name}/a.pvd:heat") == -numpy.stack([volume(2 - t) for t in range(3)])).all()
    write_collection(f"{name}/mixed.pvd", [(2, "a0.vti"), (0, "a1.vti"), (1, "a2.vti")])
    seen = ok("info", f"{name}/mixed.pvd", "--json").json
    assert seen["frame_step"] == 1 and len(seen["warnings"]) == 1, seen
    says(seen["warnings"][0], "holds 2 parts in each file", "this is pressure", "heat too", f"{name}/mixed.pvd:heat")
    assert not ok("info", f"{name}/mixed.pvd:heat", "--json").json["warnings"]
    assert (steps_of(f"{name}/mixed.pvd:heat") == -numpy.stack([volume(step) for step in (1, 2, 0)])).all()
    write_collection(f"{name}/twice.pvd", [(1, "a0.vti"), (0, "a1.vti"), (1, "a2.vti")])
    says(fails(3, "info", f"{name}/twice.pvd"), "'a0.vti' and 'a2.vti', for the time step 1")
    says(fails(3, "info", f"{name}/a.pvd", "--limit", "files=2"), "--limit files=N")
    with open(f"{name}/a.pvd", "rb") as file:
        whole = file.read()
    with open(f"{name}/cut.pvd", "wb") as file:
        file.write(whole[:-30])
    says(fails(3, "info", f"{name}/cut.pvd"), "cut short")
    write_collection(f"{name}/b.pvd", [(0, "a0.vti"), (0, "a1.vti")])
    says(fails(3, "info", f"{name}/b.pvd"), "'a0.vti' and 'a1.vti', for the time step 0")
    write_collection(f"{name}/c.pvd", [(0, "c.pvd"), (1, "c.pvd")])
    says(fails(3, "info", f"{name}/c.pvd"), "a collection in another")
    write_collection(f"{name}/d.pvd", [(0, "../jet.vti"), (1, "a1.vti")])
    says(fails(3, "info", f"{name}/d.pvd"), "leads out of the header's folder")
    write_collection(f"{name}/e.pvd", [(0, "a0.vti"), (1, "gone.vti")])
    says(fails(3, "info", f"{name}/e.pvd"), "'gone.vti'", "not there")


def test_what_differs_between_files_is_told():
    def differ(part, second, **options):
        name = folder("differ")
        write_vti(f"{name}/a_1.vti", volume(1))
        write_vti(f"{name}/a_2.vti", second, **options)
        said = "'a_1.vti' and 'a_2.vti' are no time steps of one data set"
        says(fails(3, "convert", name, "-o", "differ.npy"), said, part, f"name one file, as {name}:a_1.vti")
        seen = ok("info", name, "--json").json
        about = [(p["name"], p["about"].split(",")[0], p["chosen"]) for p in seen["parts"]]
        shape = " x ".join(str(n) for n in second.shape[::-1])
        assert about == [("a_1.vti", "6 x 5 x 4 f32", True),
                         ("a_2.vti", f"{shape} {'f64' if second.dtype == 'f8' else 'f32'}", False)], seen
        assert len([w for w in seen["warnings"] if said in w and part in w]) == 1, seen

    differ("the first has 6 x 5 x 4 samples, the second 6 x 5 x 3 samples", volume(2)[:3])
    differ("samples of f32, the second samples of f64", volume(2).astype("f8"))
    differ("a spacing of 3 along z, the second one of 4", volume(2), spacing=(1, 2, 4))


def test_files_that_may_be_anything_are_not_guessed_at():
    name = folder("mixed")
    for step in (1, 2):
        write_vti(f"{name}/a_{step}.vti", volume(step))
        write_vti(f"{name}/b_{step}.vti", volume(step + 5))
    said = fails(3, "convert", name, "-o", "mixed.npy")
    says(said, "holds several data sets: 'a_1.vti', 'a_2.vti', 'b_1.vti', 'b_2.vti'", f"{name}:a_{{t}}.vti or {name}:b_{{t}}.vti")
    for word in (f"{name}:b_{{t}}.vti", f"{name}/b_{{t}}.vti", f"{name}/b_*.vti"):
        assert (steps_of(word) == numpy.stack([volume(6), volume(7)])).all()
    assert (steps_of(f"{name}/b_{{t}}.vti:heat@1") == -volume(7)).all()
    name = folder("people")
    for step in (1, 2):
        write_nifti(f"{name}/sub-{step:02}_T1w.nii.gz", volume(step))
    says(fails(3, "convert", name, "-o", "people.npy"), "'sub-01_T1w.nii.gz', 'sub-02_T1w.nii.gz'", "sub-{t}_T1w.nii.gz")
    says(ok("info", name).message, "if they are time steps of one", f"{name}:sub-{{t}}_T1w.nii.gz")
    assert ok("info", name + "/sub-{t}_T1w.nii.gz", "--json").json["frames"] == 2
    name = folder("grid")
    for a in (1, 2):
        for b in (1, 2):
            write_nifti(f"{name}/s{a}_{b}.nii", volume(a))
    says(ok("info", name).message, "s*_{t}.nii")
    name = folder("twice")
    write_nifti(f"{name}/t1.nii", volume(1))
    write_nifti(f"{name}/t01.nii", volume(1))
    write_nifti(f"{name}/t2.nii", volume(2))
    says(fails(2, "convert", name, "-o", "twice.npy"), "'t01.nii' and 't1.nii' have the same number")
    says(ok("info", name).message, "'t01.nii' and 't1.nii' have the same number", "listed by themselves")


def test_one_step_is_read_by_the_name_of_its_file():
    name = folder("single")
    for step in (1, 2, 3):
        write_vti(f"{name}/a_{step}.vti", volume(step))
    for word in (f"{name}:a_2.vti", f"{name}/a_2.vti", f"{name}@1"):
        assert (steps_of(word) == volume(2)).all(), word
    assert (steps_of(f"{name}:a_2.vti:heat") == -volume(2)).all()
    assert ok("info", name, "--json").json["frames"] == 3


def test_headers_bring_their_data_files():
    name = folder("raw")
    for step in range(3):
        volume(step).tofile(f"{name}/x{step}.raw")
    says(fails(2, "info", name), "--raw")
    assert (steps_of(name, "--raw", "6x5x4,f32") == numpy.stack([volume(t) for t in range(3)])).all()
    for step in range(3):
        with open(f"{name}/x{step}.mhd", "w") as file:
            file.write(f"ObjectType = Image\nNDims = 3\nDimSize = 6 5 4\nElementType = MET_FLOAT\nElementDataFile = x{step}.raw\n")
    assert (steps_of(name) == numpy.stack([volume(t) for t in range(3)])).all()


def test_hdf5_and_safe_reading():
    import h5py
    name = folder("h5")
    for step in range(3):
        with h5py.File(f"{name}/step_{step}.h5", "w") as file:
            file["density"] = volume(step)
    for more in ([], ["--safe"]):
        assert (steps_of(name, *more) == numpy.stack([volume(t) for t in range(3)])).all()


def test_a_step_that_is_gone_or_cut_short_is_told():
    name = folder("cut")
    for step in range(3):
        write_nrrd(f"{name}/t{step}.nrrd", (8, 8, 8), lambda x, y, z: step + 1)
    ok("render", name + "@2", "-o", "gone.png", "--size", "8", "--overwrite", "--save-scene", "gone.vv.json")
    whole = os.path.getsize(f"{name}/t1.nrrd")
    os.truncate(f"{name}/t1.nrrd", whole - 100)
    result = volvis("convert", name, "-o", "all.npy", "--overwrite")
    assert result.code == 7, (result.code, result.message)
    samples = numpy.load("all.npy")
    assert (samples[0] == 1).all() and (samples[2] == 3).all() and (samples[1] == 0).sum() == 100
    says(result.message, "t1.nrrd")
    os.remove(f"{name}/t2.nrrd")
    says(fails(2, "render", "gone.vv.json", "-o", "gone.png", "--size", "8", "--overwrite"), "there is no time step 2")


def test_files_with_scales_of_their_own_are_values():
    name = folder("scaled")
    for step in range(3):
        image = nibabel.Nifti1Image(volume(0).transpose(2, 1, 0).astype("i2"), numpy.eye(4))
        image.header.set_slope_inter(0.5 + step, -step)
        nibabel.save(image, f"{name}/f{step}.nii")
    there = [numpy.asarray(nibabel.load(f"{name}/f{step}.nii").dataobj).transpose(2, 1, 0) for step in range(3)]
    assert (there[1] == volume(0) * 1.5 - 1).all()
    found = steps_of(name)
    assert found.dtype == "f4" and (found == numpy.stack(there)).all()
    assert (steps_of(name, "--x", "1..5", "--z", "1..2") == numpy.stack(there)[:, 1:3, :, 1:6]).all()


main()
