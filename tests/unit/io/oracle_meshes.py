"""Meshes that VTK writes are read as VTK measures them, and VTK measures what VolVis writes alike."""
import json
import subprocess
import sys
import tempfile
try:
    import vtk
except ImportError:
    print("skipped: there is no VTK for Python")
    sys.exit(77)

VOLVIS = sys.argv[1]
TOLERANCE = 1e-6


def run(*words):
    done = subprocess.run([VOLVIS, *words], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, (words, done.stderr)
    return done.stdout


def measure(mesh):
    """Volume and area, vertices at one place joined."""
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(mesh)
    joined = vtk.vtkCleanPolyData()
    joined.SetInputConnection(triangles.GetOutputPort())
    joined.Update()
    mass = vtk.vtkMassProperties()
    mass.SetInputData(joined.GetOutput())
    return mass.GetVolume(), mass.GetSurfaceArea()


def told(path):
    info = json.loads(run("info", path, "--json"))
    assert info["closed"], (path, info)
    return info["volume"], info["area"]


def same(got, want, scale=1.0):
    assert abs(got[0] - want[0] * scale**3) < TOLERANCE * want[0] * scale**3, (got, want)
    assert abs(got[1] - want[1] * scale**2) < TOLERANCE * want[1] * scale**2, (got, want)


def read(reader, path):
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def write_all(folder, mesh, want):
    for suffix, kind in (("ply", vtk.vtkPLYWriter), ("stl", vtk.vtkSTLWriter), ("obj", vtk.vtkOBJWriter)):
        for binary in (False, True):
            writer = kind()
            writer.SetInputData(mesh)
            writer.SetFileName(f"{folder}/vtk.{suffix}")
            if hasattr(writer, "SetFileTypeToBinary"):
                writer.SetFileType(vtk.VTK_BINARY if binary else vtk.VTK_ASCII)
            writer.Write()
            same(told(f"{folder}/vtk.{suffix}"), want)


def write_polygons(folder, mesh, want):
    """VTK's own XML in all of its forms, polygons and strips."""
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(mesh)
    strips = vtk.vtkStripper()
    strips.SetInputConnection(triangles.GetOutputPort())
    strips.Update()
    compressors = (None, vtk.vtkZLibDataCompressor, vtk.vtkLZ4DataCompressor, vtk.vtkLZMADataCompressor)
    for data in (mesh, strips.GetOutput()):
        for mode in ("Ascii", "Binary", "Appended"):
            for compressor in compressors:
                writer = vtk.vtkXMLPolyDataWriter()
                writer.SetInputData(data)
                writer.SetFileName(f"{folder}/vtk.vtp")
                getattr(writer, f"SetDataModeTo{mode}")()
                writer.SetCompressor(compressor() if compressor else None)
                writer.Write()
                same(told(f"{folder}/vtk.vtp"), want)


def read_all(folder, want):
    run("convert", f"{folder}/vtk.ply", "-o", f"{folder}/base.ply", "--input-unit", "mm")
    cases = [("ply", ("binary", "big-endian", "ascii"), vtk.vtkPLYReader), ("stl", ("binary", "ascii"), vtk.vtkSTLReader),
             ("obj", (None,), vtk.vtkOBJReader), ("vtp", ("raw", "base64", "ascii"), vtk.vtkXMLPolyDataReader)]
    for suffix, encodings, kind in cases:
        for encoding in encodings:
            words = ["--encoding", encoding] if encoding else []
            run("convert", f"{folder}/base.ply", "-o", f"{folder}/ours.{suffix}", "--overwrite", *words)
            same(measure(read(kind(), f"{folder}/ours.{suffix}")), want)
    run("convert", f"{folder}/vtk.stl", "-o", f"{folder}/base.stl", "--input-unit", "mm")
    # up is y there: of STL, z becomes it, and PLY has it already
    for suffix, encodings, base, top in (("glb", (None,), "stl", 3), ("gltf", ("base64", "separate"), "ply", 5)):
        for encoding in encodings:
            words = ["--encoding", encoding] if encoding else []
            run("convert", f"{folder}/base.{base}", "-o", f"{folder}/ours.{suffix}", "--overwrite", *words)
            reader = vtk.vtkGLTFReader()
            reader.SetFileName(f"{folder}/ours.{suffix}")
            geometry = vtk.vtkCompositeDataGeometryFilter()
            geometry.SetInputConnection(reader.GetOutputPort())
            geometry.Update()
            got = geometry.GetOutput()
            same(measure(got), want, 1e-3)  # metres
            assert abs(got.GetBounds()[top] - 0.7e-3) < 1e-8, got.GetBounds()
            same(told(f"{folder}/ours.{suffix}"), want)


def main():
    sphere = vtk.vtkSphereSource()
    sphere.SetThetaResolution(13)
    sphere.SetPhiResolution(11)
    sphere.SetCenter(0, 0, 0.2)
    sphere.Update()
    want = measure(sphere.GetOutput())
    with tempfile.TemporaryDirectory() as folder:
        write_all(folder, sphere.GetOutput(), want)
        write_polygons(folder, sphere.GetOutput(), want)
        read_all(folder, want)
    print("VTK and VolVis measure the same")


main()
