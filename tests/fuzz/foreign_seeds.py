#!/usr/bin/env python3
"""Small files of the formats that others write, by their own libraries: seeds for `mutate` and for the fuzz targets. What is
not installed is left out.

    foreign_seeds.py FOLDER                       files in FOLDER, volumes that are folders in FOLDER/volumes
    foreign_seeds.py --targets FOLDER TARGET...   the files by fuzz target, a folder for each, empty where nobody writes its format
"""
import os
import shutil
import sys
import tempfile

import numpy as np

DATA = (np.arange(5 * 4 * 3, dtype="u2").reshape(3, 4, 5) * 37 % 251).astype("u2")


def hdf5(folder):
    import h5py
    for name, options in {"plain": {}, "gzip": {"compression": "gzip", "chunks": (2, 4, 5)}, "shuffled": {"compression": "gzip", "shuffle": True, "fletcher32": True, "chunks": (3, 2, 5)}}.items():
        for version in ("earliest", "latest"):
            with h5py.File(f"{folder}/{name}_{version}.h5", "w", libver=version) as file:
                data = file.create_group("a").create_dataset("v", data=DATA, **options)
                data.attrs["element_size_um"] = (1.0, 0.5, 0.5)
                data.attrs["axes"] = "zyx"


def tiff(folder):
    import tifffile
    tifffile.imwrite(f"{folder}/plain.tif", DATA)
    tifffile.imwrite(f"{folder}/imagej.tif", DATA, imagej=True, metadata={"spacing": 2.0, "unit": "um", "axes": "ZYX"})
    tifffile.imwrite(f"{folder}/big.tif", DATA, bigtiff=True, byteorder=">")
    tifffile.imwrite(f"{folder}/ome.ome.tif", DATA, metadata={"axes": "ZYX", "PhysicalSizeX": 0.5, "PhysicalSizeXUnit": "um"})
    for name in ("zlib", "lzw", "packbits", "zstd"):
        try:
            tifffile.imwrite(f"{folder}/{name}.tif", DATA, compression=name)
        except Exception:
            os.unlink(f"{folder}/{name}.tif")  # begun, and its codec is not there
    tifffile.imwrite(f"{folder}/tiles.tif", np.zeros((2, 40, 40), "u1") + np.arange(40, dtype="u1"), tile=(16, 16))


def dicom(folder):
    import pydicom
    from pydicom.dataset import FileDataset, FileMetaDataset
    from pydicom.uid import ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian, DeflatedExplicitVRLittleEndian, RLELossless, generate_uid

    def dataset(path, syntax, k=0, frames=0):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
        meta.MediaStorageSOPInstanceUID = f"1.2.3.{k + 1}"
        meta.TransferSyntaxUID = syntax
        ds = FileDataset(path, {}, file_meta=meta, preamble=bytes(128))
        ds.is_little_endian = syntax != ExplicitVRBigEndian
        ds.is_implicit_VR = syntax == ImplicitVRLittleEndian
        ds.SOPClassUID, ds.SOPInstanceUID, ds.StudyInstanceUID, ds.SeriesInstanceUID = meta.MediaStorageSOPClassUID, f"1.2.3.{k + 1}", "1.2.4", "1.2.5"
        ds.Modality, ds.PatientName, ds.SeriesDescription, ds.InstanceNumber = "CT", "A^B", "seed", k + 1
        ds.ImagePositionPatient, ds.ImageOrientationPatient = [0, 0, 2.0 * k], [1, 0, 0, 0, 1, 0]
        ds.PixelSpacing, ds.SliceThickness = [0.5, 0.5], 2.0
        ds.SamplesPerPixel, ds.PhotometricInterpretation = 1, "MONOCHROME2"
        ds.Rows, ds.Columns, ds.BitsAllocated, ds.BitsStored, ds.HighBit, ds.PixelRepresentation = 4, 5, 16, 12, 11, 0
        ds.RescaleSlope, ds.RescaleIntercept = 1, -1024
        if frames:
            ds.NumberOfFrames = frames
        ds.PixelData = (DATA if frames else DATA[k % 3]).astype("u2" if ds.is_little_endian else ">u2").tobytes()
        return ds

    for name, syntax in {"explicit": ExplicitVRLittleEndian, "implicit": ImplicitVRLittleEndian, "big": ExplicitVRBigEndian, "deflated": DeflatedExplicitVRLittleEndian}.items():
        path = f"{folder}/{name}.dcm"
        dataset(path, syntax).save_as(path, write_like_original=False)
        drawn = dataset(f"{folder}/structures_{name}.dcm", syntax)
        del drawn.PixelData
        drawn.Modality = "RTSTRUCT"
        roi, contours, outline = pydicom.Dataset(), pydicom.Dataset(), pydicom.Dataset()
        roi.ROINumber, roi.ROIName = 1, "Liver"
        outline.ContourGeometricType, outline.ContourData = "CLOSED_PLANAR", [0, 0, 0, 9, 0, 0, 9, 9, 0]
        contours.ROIDisplayColor, contours.ReferencedROINumber, contours.ContourSequence = [255, 0, 0], 1, [outline]
        drawn.StructureSetROISequence, drawn.ROIContourSequence = [roi], [contours]
        drawn.save_as(f"{folder}/structures_{name}.dcm", write_like_original=False)
    path = f"{folder}/frames.dcm"
    dataset(path, ExplicitVRLittleEndian, frames=3).save_as(path, write_like_original=False)
    try:
        ds = dataset(f"{folder}/rle.dcm", ExplicitVRLittleEndian)
        ds.compress(RLELossless)
        ds.save_as(f"{folder}/rle.dcm", write_like_original=False)
    except Exception:
        pass
    os.makedirs(f"{folder}/volumes/series", exist_ok=True)
    for k in range(3):
        path = f"{folder}/volumes/series/{k}.dcm"
        dataset(path, ExplicitVRLittleEndian, k).save_as(path, write_like_original=False)


def zarr_arrays(folder):
    import numcodecs
    import zarr
    for name, codec in {"raw": None, "zlib": numcodecs.Zlib(), "blosc": numcodecs.Blosc("lz4"), "zstd": numcodecs.Zstd()}.items():
        root = zarr.open_group(f"{folder}/volumes/{name}.zarr", mode="w")
        data = root.create_dataset("0", data=DATA, chunks=(2, 2, 3), compressor=codec)
        root.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"],
                                      "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [2.0, 0.5, 0.5]}]}]}]
        del data


def mrc(folder):
    import mrcfile
    for name, kind in {"short": "i2", "float": "f4"}.items():
        with mrcfile.new(f"{folder}/{name}.mrc", overwrite=True) as file:
            file.set_data(DATA.astype(kind))
            file.voxel_size = 1.5


def vtk_files(folder):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk
    image = vtk.vtkImageData()
    image.SetDimensions(5, 4, 3)
    image.SetSpacing(0.5, 0.5, 2)
    scalars = numpy_to_vtk(DATA.ravel(), deep=True)
    scalars.SetName("v")
    image.GetPointData().SetScalars(scalars)
    for name, mode, zlib in (("ascii", "Ascii", 0), ("binary", "Binary", 0), ("binary_zlib", "Binary", 1), ("appended", "Appended", 0), ("appended_zlib", "Appended", 1)):
        writer = vtk.vtkXMLImageDataWriter()
        writer.SetFileName(f"{folder}/{name}.vti")
        writer.SetInputData(image)
        getattr(writer, f"SetDataModeTo{mode}")()
        if zlib:
            writer.SetCompressorTypeToZLib()
        else:
            writer.SetCompressorTypeToNone()
        writer.Write()
    for name, binary in (("ascii", 0), ("binary", 1)):
        writer = vtk.vtkStructuredPointsWriter()
        writer.SetFileName(f"{folder}/{name}.vtk")
        writer.SetInputData(image)
        writer.SetFileType(vtk.VTK_BINARY if binary else vtk.VTK_ASCII)
        writer.Write()
    for name, packed in (("raw", 0), ("zlib", 1)):
        writer = vtk.vtkMetaImageWriter()
        writer.SetFileName(f"{folder}/{name}.mha")
        writer.SetInputData(image)
        writer.SetCompression(packed)
        writer.Write()


def nibabel_files(folder):
    import nibabel
    nibabel.save(nibabel.Nifti1Image(DATA.T.astype("i2"), np.diag([0.5, 0.5, 2, 1])), f"{folder}/nibabel.nii")
    nibabel.save(nibabel.MGHImage(DATA.T.astype("i2"), np.diag([0.5, 0.5, 2, 1])), f"{folder}/nibabel.mgz")


def numpy_files(folder):
    np.save(f"{folder}/c.npy", DATA)
    np.save(f"{folder}/fortran.npy", np.asfortranarray(DATA.astype(">f4")))
    np.savez(f"{folder}/stored.npz", v=DATA)
    np.savez_compressed(f"{folder}/packed.npz", v=DATA, other=DATA[0])


def netcdf(folder):
    from scipy.io import netcdf_file
    for version in (1, 2):
        with netcdf_file(f"{folder}/v{version}.nc", "w", version=version) as file:
            for name, n in zip("zyx", DATA.shape):
                file.createDimension(name, n)
                axis = file.createVariable(name, "f8", (name,))
                axis[:] = np.arange(n) * 0.5
                axis.units = "um"
            file.createVariable("v", "i2", ("z", "y", "x"))[:] = DATA


def vtk_grids(folder):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk
    grid = vtk.vtkRectilinearGrid()
    grid.SetDimensions(5, 4, 3)
    for axis, n in zip("XYZ", (5, 4, 3)):
        getattr(grid, f"Set{axis}Coordinates")(numpy_to_vtk(np.arange(n) ** 1.5, deep=True))
    scalars = numpy_to_vtk(DATA.ravel(), deep=True)
    scalars.SetName("v")
    grid.GetPointData().SetScalars(scalars)
    for name, mode in (("ascii", "Ascii"), ("binary", "Binary"), ("appended", "Appended")):
        writer = vtk.vtkXMLRectilinearGridWriter()
        writer.SetFileName(f"{folder}/{name}.vtr")
        writer.SetInputData(grid)
        getattr(writer, f"SetDataModeTo{mode}")()
        writer.Write()


def vtk_meshes(folder):
    import vtk
    ball = vtk.vtkSphereSource()
    ball.SetThetaResolution(6)
    ball.SetPhiResolution(5)
    ball.Update()
    for name, writer, kind in (("text.ply", vtk.vtkPLYWriter, 1), ("bytes.ply", vtk.vtkPLYWriter, 2), ("text.stl", vtk.vtkSTLWriter, 1), ("bytes.stl", vtk.vtkSTLWriter, 2),
                               ("a.obj", vtk.vtkOBJWriter, 0), ("a.vtp", vtk.vtkXMLPolyDataWriter, 0)):
        writer = writer()
        writer.SetFileName(f"{folder}/{name}")
        writer.SetInputConnection(ball.GetOutputPort())
        if kind:
            writer.SetFileType(kind)
        writer.Write()
    blocks, parts = vtk.vtkMultiBlockDataSet(), vtk.vtkMultiBlockDataSet()  # a building of parts, as the writer wants it
    parts.SetBlock(0, ball.GetOutput())
    blocks.SetBlock(0, parts)
    writer = vtk.vtkGLTFWriter()
    writer.SetFileName(f"{folder}/a.gltf")
    writer.SetInlineData(True)
    writer.SetInputData(blocks)
    writer.Write()


def pictures(folder):
    from PIL import Image
    rgb = Image.fromarray(np.stack([DATA[0].astype("u1")] * 3, -1))
    for name, options in {"a.jpg": {}, "progressive.jpg": {"progressive": True, "quality": 30}, "exact.webp": {"lossless": True}, "lossy.webp": {}, "a.pdf": {}, "picture.tiff": {}, "deflate.tiff": {"compression": "tiff_adobe_deflate"}}.items():
        rgb.save(f"{folder}/{name}", **options)


def rarer_pictures(folder):
    import cv2  # of OpenCV: OpenEXR only where it was built with it
    os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
    for name in ("a.pfm", "a.exr"):
        cv2.imwrite(f"{folder}/{name}", np.stack([DATA[0].astype("f4")] * 3, -1))


def nrrd_files(folder):
    try:
        import nrrd
        for name in ("raw", "gzip", "bzip2", "ASCII"):
            nrrd.write(f"{folder}/pynrrd_{name}.nrrd", DATA, {"encoding": name, "space": "left-posterior-superior", "space directions": np.eye(3)})
    except ImportError:
        import SimpleITK
        SimpleITK.WriteImage(SimpleITK.GetImageFromArray(DATA), f"{folder}/itk.nrrd")
        SimpleITK.WriteImage(SimpleITK.GetImageFromArray(DATA), f"{folder}/itk_gzip.nrrd", True)


def put(folder, name, data):
    os.makedirs(os.path.dirname(f"{folder}/{name}"), exist_ok=True)
    with open(f"{folder}/{name}", "wb") as file:
        file.write(data if isinstance(data, bytes) else data.encode())


def headers_with_data(folder):
    """Volumes whose samples lie in other files than their header, which is called head.*"""
    import gzip
    import struct
    import zlib
    raw, slices = DATA.tobytes(), [plane.tobytes() for plane in DATA]
    nrrd = "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: {}\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,2)\nspace: LPS\n{}\n"
    mhd = "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = 0.5 0.5 2\nElementType = MET_USHORT\nElementByteOrderMSB = False\n{}ElementDataFile = {}\n"
    vvh = "dims: 5 4 3\ntype: u16\nbyte order: little\nspacing: 0.5 0.5 2\nunit: mm\n{}data: {}\n"
    dx = ('object 1 class gridpositions counts 3 4 5\norigin 0 0 0\ndelta 1 0 0\ndelta 0 1 0\ndelta 0 0 1\nobject 2 class gridconnections counts 3 4 5\n'
          'object 3 class array type unsigned short rank 0 items 60 lsb binary data file "data.raw" 0\nobject "f" class field\ncomponent "positions" value 1\n'
          'component "connections" value 2\ncomponent "data" value 3\nend\n')
    ome = ('<OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06" UUID="urn:uuid:0"><Image ID="Image:0"><Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint16" '
           'SizeX="5" SizeY="4" SizeZ="3" SizeC="1" SizeT="1" PhysicalSizeX="0.5"><Channel ID="Channel:0:0"/>{}</Pixels></Image></OME>')
    planes = "".join(f'<TiffData IFD="0" FirstZ="{z}" PlaneCount="1"><UUID FileName="{name}">urn:uuid:{z}</UUID></TiffData>' for z, name in enumerate(("head.ome.tif", "b.tif", "c.tif")))
    analyze = bytearray(348)
    struct.pack_into("<i", analyze, 0, 348)
    struct.pack_into("<8h", analyze, 40, 3, 5, 4, 3, 1, 1, 1, 1)
    struct.pack_into("<2h8f", analyze, 70, 4, 16, 1, 0.5, 0.5, 2, 1, 1, 1, 1)
    nifti = bytes(analyze[:344]) + b"ni1\0"
    sets = {
        "nrrd_one": {"head.nhdr": nrrd.format("raw", "data file: data.raw"), "data.raw": raw},
        "nrrd_gzip": {"head.nhdr": nrrd.format("gzip", "byte skip: -1\ndata file: data.raw.gz").replace("byte skip: -1\n", ""), "data.raw.gz": gzip.compress(raw, mtime=0)},
        "nrrd_list": {"head.nhdr": nrrd.format("raw", "data file: LIST 2\n0.raw\n1.raw\n2.raw"), **{f"{i}.raw": b for i, b in enumerate(slices)}},
        "nrrd_pattern": {"head.nhdr": nrrd.format("gzip", "data file: s%02d.gz 1 3 1 2"), **{f"s{i + 1:02}.gz": gzip.compress(b, mtime=0) for i, b in enumerate(slices)}},
        "meta_one": {"head.mhd": mhd.format("HeaderSize = 3\n", "data.raw"), "data.raw": b"abc" + raw},
        "meta_zlib": {"head.mhd": mhd.format("CompressedData = True\n", "data.zraw"), "data.zraw": zlib.compress(raw)},
        "meta_list": {"head.mhd": mhd.format("", "LIST\n0.raw\n1.raw\n2.raw"), **{f"{i}.raw": b for i, b in enumerate(slices)}},
        "meta_pattern": {"head.mhd": mhd.format("", "s%d.raw 0 2 1"), **{f"s{i}.raw": b for i, b in enumerate(slices)}},
        "vvh_one": {"head.vvh": vvh.format("skip: -1\n", "data.raw"), "data.raw": b"abc" + raw},
        "vvh_list": {"head.vvh": vvh.format("coding: gzip\n", "\na.gz\nb.gz"), "a.gz": gzip.compress(raw[:60], mtime=0), "b.gz": gzip.compress(raw[60:], mtime=0)},
        "vvh_pattern": {"head.vvh": vvh.format("frames: 3\n", "s%03d.raw 0 2").replace("5 4 3", "5 4 1"), **{f"s{i:03}.raw": b for i, b in enumerate(slices)}},
        "dat": {"head.dat": "ObjectFileName: data.raw\nResolution: 5 4 3\nSliceThickness: 0.5 0.5 2\nFormat: USHORT\nObjectModel: I\n", "data.raw": raw},
        "general": {"head.general": "file = data.raw\ngrid = 3 x 4 x 5\nformat = lsb binary\nfield = v\ntype = unsigned short\nstructure = scalar\nmajority = row\nheader = bytes 3\n"
                                    "positions = 0, 1, 0, 1, 0, 1\nend\n", "data.raw": b"abc" + raw},
        "general_text": {"head.general": "file = text.txt\ngrid = 3 x 4 x 5\nformat = text\nfield = v\ntype = short\nstructure = 3-vector\n"
                                         "interleaving = field\nheader = bytes 5\npositions = 0, 1, 0, 1, 0, 1\nend\n",
                         "text.txt": "head\n" + "".join(f"{v} {v + 1} {v + 2}\n" for v in DATA.ravel())},
        "dx": {"head.dx": dx, "data.raw": raw},
        "analyze": {"head.hdr": bytes(analyze), "head.img": raw},
        "nifti": {"head.hdr": nifti, "head.img": raw},
    }
    for name, files in sets.items():
        for file, data in files.items():
            put(f"{folder}/volumes/{name}", file, data)
    import tifffile
    for z, name in enumerate(("head.ome.tif", "b.tif", "c.tif")):
        os.makedirs(f"{folder}/volumes/ome_files", exist_ok=True)
        tifffile.imwrite(f"{folder}/volumes/ome_files/{name}", DATA[z], description=ome.format(planes), metadata=None)
    os.makedirs(f"{folder}/volumes/ome_companion", exist_ok=True)
    tifffile.imwrite(f"{folder}/volumes/ome_companion/head.ome.tif", DATA, description='<OME><BinaryOnly MetadataFile="a.companion.ome" UUID="urn:uuid:1"/></OME>', metadata=None, photometric="minisblack")
    put(f"{folder}/volumes/ome_companion", "a.companion.ome", ome.format('<TiffData IFD="0" PlaneCount="3"/>'))


def slices(folder):
    import tifffile
    from PIL import Image
    for kind in ("tif", "png", "jpg"):
        os.makedirs(f"{folder}/volumes/slices_{kind}", exist_ok=True)
        for z in range(4):
            path = f"{folder}/volumes/slices_{kind}/s{z + 1}.{kind}"
            if kind == "tif":
                tifffile.imwrite(path, DATA[z % 3])
            else:
                Image.fromarray(DATA[z % 3].astype("u1")).save(path)


def zarr3(folder):
    """By hand: zarr-python of Debian writes version 2."""
    import gzip
    import json
    import struct

    def about(codecs, chunk=(2, 4, 5)):
        return json.dumps({"zarr_format": 3, "node_type": "array", "shape": DATA.shape, "data_type": "uint16", "fill_value": 0, "codecs": codecs, "attributes": {},
                           "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}}, "chunk_key_encoding": {"name": "default"}})

    little = {"name": "bytes", "configuration": {"endian": "little"}}
    padded = np.concatenate([DATA, np.zeros((1, 4, 5), "u2")])
    pieces = [padded[i:i + 2].tobytes() for i in (0, 2)]
    for name, codecs, pack in (("raw", [little], lambda b: b), ("gzip", [little, {"name": "gzip", "configuration": {"level": 5}}], lambda b: gzip.compress(b, mtime=0))):
        for i, piece in enumerate(pieces):
            put(f"{folder}/volumes/v3_{name}.zarr", f"c/{i}/0/0", pack(piece))
        put(f"{folder}/volumes/v3_{name}.zarr", "zarr.json", about(codecs))
    shard = [{"name": "sharding_indexed", "configuration": {"chunk_shape": [2, 4, 5], "codecs": [little], "index_codecs": [little], "index_location": "end"}}]
    put(f"{folder}/volumes/v3_shard.zarr", "0/zarr.json", about(shard, (4, 4, 5)))
    put(f"{folder}/volumes/v3_shard.zarr", "0/c/0/0/0", b"".join(pieces) + struct.pack("<4Q", 0, 80, 80, 80))
    attributes = {"ome": {"version": "0.5", "multiscales": [{"axes": [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"],
                                                             "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [2, 0.5, 0.5]}]}]}]}}
    put(f"{folder}/volumes/v3_shard.zarr", "zarr.json", json.dumps({"zarr_format": 3, "node_type": "group", "attributes": attributes}))


MAKERS = (hdf5, tiff, dicom, zarr_arrays, mrc, vtk_files, nibabel_files, numpy_files, netcdf, vtk_grids, vtk_meshes, pictures, rarer_pictures, nrrd_files, headers_with_data,
          slices, zarr3)

TARGETS = {".h5": ["hdf5"], ".tif": ["tiff", "tiff_image"], ".tiff": ["tiff_image"], ".dcm": ["dicom"], ".mrc": ["mrc"], ".vti": ["vti"], ".vtr": ["vtr"], ".vtk": ["vtk"],
           ".mha": ["metaimage"], ".nii": ["nifti"], ".npy": ["npy"], ".nrrd": ["nrrd", "seg_nrrd"], ".jpg": ["jpeg"], ".webp": ["webp"], ".pdf": ["pdf"], ".exr": ["exr"],
           ".pfm": ["pfm"], ".ply": ["mesh"], ".stl": ["mesh"], ".obj": ["mesh"], ".vtp": ["mesh"], ".gltf": ["mesh"]}


def make_all(folder):
    os.makedirs(f"{folder}/volumes", exist_ok=True)
    for make in MAKERS:
        try:
            make(folder)
        except Exception as why:  # a library is absent or of another version: fewer seeds
            print(f"{make.__name__}: {why}", file=sys.stderr)


def coded(folder, to):
    """For the target `source`, whose first two bytes say how the rest is coded and read."""
    import bz2
    import gzip
    for byte, pack in ((0, bytes), (1, gzip.compress), (2, bz2.compress), (5, lambda b: gzip.compress(gzip.compress(b)))):
        put(to, f"python-{byte}", bytes([byte, 3]) + pack(DATA.tobytes()))


def plain(folder, to):
    """For the target `raw`, whose first line is the layout."""
    put(to, "numpy", b"5x4x3,u16,spacing=0.5x0.5x2\n" + DATA.tobytes())


def one_chunk(folder, to):
    """For the target `zarr`: metadata and the only chunk in one file."""
    import zarr
    for name, options in {"default": {}, "plain": {"compressor": None}}.items():
        zarr.open_array(f"{folder}/{name}", mode="w", shape=DATA.shape, chunks=DATA.shape, dtype="u2", **options)[:] = DATA
        with open(f"{folder}/{name}/.zarray", "rb") as meta, open(f"{folder}/{name}/0.0.0", "rb") as chunk:
            put(to, name, b".zarray\n" + meta.read() + b"\n--\n" + chunk.read())


def make_targets(folder, targets):
    with tempfile.TemporaryDirectory() as made:
        make_all(made)
        for target in targets:
            shutil.rmtree(f"{folder}/{target}", ignore_errors=True)
            os.makedirs(f"{folder}/{target}")
        for name in sorted(os.listdir(made)):
            for target in TARGETS.get(os.path.splitext(name)[1], ()):
                if target in targets:
                    shutil.copy(f"{made}/{name}", f"{folder}/{target}/{name}")
        for target, make in (("source", coded), ("raw", plain), ("zarr", one_chunk)):
            try:
                if target in targets:
                    make(made, f"{folder}/{target}")
            except Exception as why:
                print(f"{target}: {why}", file=sys.stderr)


def main():
    if sys.argv[1] == "--targets":
        make_targets(sys.argv[2], sys.argv[3:])
    else:
        make_all(sys.argv[1])


if __name__ == "__main__":
    main()
