"""Seconds that VTK, nibabel, tifffile, h5py, pydicom or zarr take to read a volume: peer_reading.py PROGRAM FILE ROUNDS.

Every sample is added up, as bench/reading.c does. Prints one line for each round, the seconds that passed and
those of all processors together, then the sum of 8-byte words.
"""
import glob
import os
import re
import sys
import time

import numpy as np


def vtk_samples(reader):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    reader.Update()
    return vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())


def with_vtk(path):
    import vtkmodules.vtkIOImage as images
    import vtkmodules.vtkIOXML as xml

    if os.path.isdir(path):
        reader = images.vtkDICOMImageReader()
        reader.SetDirectoryName(path)
    elif path.endswith(".vti"):
        reader = xml.vtkXMLImageDataReader()
        reader.SetFileName(path)
    elif path.endswith(".raw"):
        reader = images.vtkImageReader2()
        reader.SetFileName(path)
        reader.SetFileDimensionality(3)
        n = int(re.search(r"_(\d+)x", path)[1])
        reader.SetDataExtent(0, n - 1, 0, n - 1, 0, n - 1)
        reader.SetDataScalarTypeToUnsignedShort()
        reader.SetDataByteOrderToLittleEndian()
    else:
        reader = {".tif": images.vtkTIFFReader, ".nrrd": images.vtkNrrdReader, ".gz": images.vtkNIFTIImageReader}[
            os.path.splitext(path)[1]
        ]()
        reader.SetFileName(path)
    return vtk_samples(reader)


def with_nibabel(path):
    import nibabel

    return np.asanyarray(nibabel.load(path).dataobj).T  # as it lies: x fastest


def with_tifffile(path):
    import tifffile

    return tifffile.imread(path, maxworkers=2)


def with_pydicom(path):
    import pydicom

    slices = [pydicom.dcmread(name) for name in glob.glob(path + "/*")]
    slices.sort(key=lambda s: s.ImagePositionPatient[2])
    return np.stack([s.pixel_array for s in slices])


def with_zarr(path):
    import zarr

    return zarr.open(path, mode="r")[:]


def with_h5py(path):
    import h5py

    with h5py.File(path, "r") as file:
        return file["volume"][()]


def with_numpy(path):
    return np.fromfile(path, dtype="<u2")


def main():
    read = globals()["with_" + sys.argv[1]]
    total = 0
    for _ in range(int(sys.argv[3])):
        start, start_cpu = time.monotonic(), time.process_time()
        samples = read(sys.argv[2])
        total = int(np.ascontiguousarray(samples).reshape(-1).view("<u8").sum(dtype="<u8"))
        print(f"{time.monotonic() - start:.6f} {time.process_time() - start_cpu:.6f}", flush=True)
        del samples
    print("sum", total)


if __name__ == "__main__":
    main()
