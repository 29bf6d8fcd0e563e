"""Files made to break readers: every kind of failure that the readers of others have had, made again.

A case is (name, bytes). Each was, in some other program, an overflow, an endless loop, a request for gigabytes, or
wrong data with a success code.
"""
import bz2
import functools
import gzip
import io
import json
import os
import random
import struct
import sys
import zlib

MI = 1 << 20


# NIfTI, Analyze, NumPy, NRRD, raw -------------------------------------------------------------------------------------

def nifti1(dims, datatype=16, bits=32, offset=352.0, n=377, slope=1.0, size=348, magic=b"n+1\0"):
    header = bytearray(max(n, 352))
    struct.pack_into("<i", header, 0, size)
    struct.pack_into("<8h", header, 40, *(list(dims) + [1] * 8)[:8])
    struct.pack_into("<2h", header, 70, datatype, bits)
    struct.pack_into("<8f", header, 76, *([1.0] * 8))
    struct.pack_into("<2f", header, 108, offset, slope)
    header[344:348] = magic
    return bytes(header[:n])


def nifti2(dims, n=540):
    header = bytearray(544)
    struct.pack_into("<i", header, 0, 540)
    header[4:12] = b"n+2\0\r\n\x1a\n"
    struct.pack_into("<2h", header, 12, 16, 32)
    struct.pack_into("<8q", header, 16, *dims)
    struct.pack_into("<q", header, 168, 544)
    return bytes(header[:n])


def nrrd(sizes, encoding="raw", kind="uchar", data=b"", more=""):
    return (f"NRRD0004\ntype: {kind}\ndimension: {len(sizes)}\nsizes: {' '.join(map(str, sizes))}\nencoding: {encoding}\n"
            f"endian: little\n{more}\n").encode() + data


def npy(shape, descr="|u1", data=b""):
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(text)) + text + data


def plain_headers():
    yield "377 bytes that ask for 34 GiB.nii", nifti1([3, 2048, 2048, 2200])
    yield "rank 200 in 540 bytes.nii", nifti2([200, 2**62, 2**62, -2**63, -1, 0, 1, 2])
    yield "product of axes past 64 bits.nii", nifti2([7, 2**20, 2**20, 2**20, 2**20, 2**20, 1, 1])
    yield "product that wraps to little.nii", nifti2([3, 2**31, 2**31, 4, 1, 1, 1, 1])
    yield "1034 x 1034 x 1020 u16 cut short.nii", nifti1([3, 1034, 1034, 1020], 512, 16, n=4096)
    yield "offset that is no number.nii", nifti1([3, 2, 2, 2], offset=float("nan"), n=400)
    yield "offset infinite.nii", nifti1([3, 2, 2, 2], offset=float("inf"), n=400)
    yield "offset of 3e38.nii", nifti1([3, 2, 2, 2], offset=3e38, n=400)
    yield "extension of 2 GiB.nii", nifti1([3, 2, 2, 2], offset=1e9, n=352)[:348] + b"\1\0\0\0" + struct.pack("<ii", 0x7ffffff0, 6)
    yield "negative dims.nii", nifti1([3, -2, -2, -2])
    yield "header size that is swapped wrong.nii", nifti1([3, 2, 2, 2], size=0x7fffffff)
    for suffix in ("nii", "hdr", "img", "nrrd", "nhdr", "npy", "mhd", "mha", "dcm", "tif", "h5", "nc", "mrc", "vti", "vtk", "raw",
                   "czi", "lsm", "ics", "mnc", "mgz", "mgh", "png", "jpg", "dat", "zarr", "xml", "pvm", "slc", "v3draw", "dx", "bin"):
        yield f"six bytes.{suffix}", b"\x5c\x01\x00\x00\xff\x7f"
        yield f"no bytes.{suffix}", b""
    yield "sizes past 64 bits.nrrd", nrrd([99999999999999999999, 1, 1])
    yield "product past 64 bits.nrrd", nrrd([1048576] * 5, kind="double")
    yield "tebibyte of text.nrrd", nrrd([1048576, 1024, 1024], "ascii", data=b"1 2 3")
    yield "key without end.nrrd", b"NRRD0004\n" + b"a" * (4 * MI)
    yield "a hundred thousand keys.nrrd", b"NRRD0004\n" + b"".join(b"k%d:=v\n" % i for i in range(100000))
    yield "header that never ends.nrrd", b"NRRD0004\ntype: uchar\n" + b"# " + b"x" * 1000 + (b"\n# " + b"x" * 1000) * 20000
    yield "trillion data files.nrrd", nrrd([4, 4], more="data file: %d 1 1000000000000 1\n")
    yield "data file is itself.nrrd", nrrd([4, 4, 4], more="data file: data file is itself.nrrd\n")
    yield "exabyte.npy", npy((2**20, 2**20, 2**20), "<f8")
    yield "overflow.npy", npy((2**62, 4, 4))
    yield "header of 4 GiB.npy", b"\x93NUMPY\x02\0" + b"\xff\xff\xff\xff"
    yield "shape nested.npy", npy("(" * 5000)
    yield "objects.npy", npy((4, 4, 4), "|O", b"\x80\x04cos\nsystem\n")
    yield "a_1048576x1048576x1048576_f64.raw", b"abc"


def more_headers():
    """Sizes, counts and offsets in the headers of the other formats."""
    for n in (0, 1, 6):
        for end in ("nii", "hdr", "img", "nrrd", "mha", "npy", "mrc", "tif", "dcm", "h5", "vti", "slc", "pvm", "inr", "cube"):
            yield f"{n} bytes.{end}", (b"\x5c\x01\0\0\0\0", b"NRRD00", b"\x93NUMPY", b"II*\0\x08\0")[n % 4][:n]
    for rank in (0, -1, 8):
        yield f"rank {rank}.nii", nifti1([rank, 2, 2, 2, 1, 1, 1, 1])
    yield "samples in a file that is not there.hdr", nifti1([3, 1000, 1000, 1300], magic=b"ni1\0")
    for name, at in (("slope", 112), ("offset of values", 116), ("step", 80), ("shift", 268), ("quaternion", 256), ("matrix", 280), ("range", 124)):
        for what, value in (("nan", float("nan")), ("infinite", float("inf")), ("3e38", 3e38)):
            header = bytearray(nifti1([3, 2, 2, 2], 2, 8, n=352))
            struct.pack_into("<2h", header, 252, 1, 1)
            struct.pack_into("<f", header, at, value)
            yield f"{name} {what}.nii", bytes(header) + bytes(8)
    squeezed = zlib.compress(bytes(64))
    mha = "ObjectType = Image\nNDims = 3\nDimSize = {}\nElementType = MET_UCHAR\n{}ElementDataFile = LOCAL\n"
    packed = "CompressedData = True\nCompressedDataSize = {}\n"
    yield "inflate that fails.mha", mha.format("4 4 4", packed.format(12)).encode() + squeezed[:6] + b"\xff" * 6
    yield "inflate that is cut.mha", mha.format("40 40 40", packed.format(9)).encode() + zlib.compress(random.Random(64).randbytes(64000))[:9000]
    yield "says an exabyte is packed.mha", mha.format("4 4 4", packed.format(2**60)).encode() + squeezed[:3]
    yield "inflates to a gibibyte.mha", mha.format("4 4 4", packed.format("")).replace("CompressedDataSize = \n", "").encode() + zeros_deflate(b"", 1024, 31)
    for dims in ("99999999999 1 1", "-4 4 4", "4 4", "4 4 4 4", "1048576 1048576 1048576", "0 4 4", "nan 4 4", "4294967297 4 4"):
        yield f"dims {dims}.mha", mha.format(dims, "").encode() + bytes(64)
    yield "list of slices that is short.mhd", mha.format("4 4 400", "").replace("LOCAL", "LIST").encode() + b"a.raw\nb.raw\n"
    yield "HeaderSize of an exabyte.mha", mha.format("4 4 4", f"HeaderSize = {2**60}\n").encode() + bytes(64)
    yield "HeaderSize below zero.mha", mha.format("4 4 4", "HeaderSize = -9223372036854775808\n").encode() + bytes(64)
    mrc = bytearray(1024 + 64)
    struct.pack_into("<10i", mrc, 0, 4, 4, 4, 0, 0, 0, 0, 4, 4, 4)
    struct.pack_into("<6f3i", mrc, 40, 4, 4, 4, 90, 90, 90, 1, 2, 3)
    mrc[208:216] = b"MAP \x44\x44\0\0"
    for what, at, value in (("extended header of 2 GiB", 92, 2**31 - 1), ("extended header below zero", 92, -5), ("2^31 columns", 0, 2**31 - 1), ("negative rows", 4, -4),
                            ("mode 77", 12, 77), ("axes 1 1 1", 68, 1), ("no columns", 0, 0), ("2^31 sections", 8, 2**31 - 1)):
        lies = bytearray(mrc)
        struct.pack_into("<i", lies, at, value)
        yield f"{what}.mrc", bytes(lies)
    for what, line in (("2^31 atoms", "2147483647 0 0 0"), ("-2^31 atoms and orbitals", "-2147483648 0 0 0")):
        yield f"{what}.cube", f"t\nu\n {line}\n 2 1 0 0\n 2 0 1 0\n 2 0 0 1\n 1 1 0 0 0\n".encode() + b"1 " * 8
    yield "sizes past 64 bits.cube", b"t\nu\n 0 0 0 0\n 1000000 1 0 0\n 1000000 0 1 0\n 1000000 0 0 1\n 1 2 3\n"
    yield "two thousand million orbitals.cube", b"t\nu\n -1 0 0 0\n 2 1 0 0\n 2 0 1 0\n 2 0 0 1\n 1 1 0 0 0\n 2000000000 1 2 3\n"
    yield "a tebibyte.pvm", b"PVM3\n65536 65536 256\n1 1 1\n1\nabc"
    yield "packed nothing.pvm", b"DDS v3d\n" + bytes(100)
    yield "packed ones.pvm", b"DDS v3d\n" + b"\xff" * 100000
    yield "sizes past 32 bits.slc", b"11111\n99999 99999 99999 8\n1 1 1\n1 6 0 0\n2 1 Xabc"
    yield "icon of two thousand million pixels.slc", b"11111\n3 2 2 8\n1 1 1\n1 6 0 0\n2000000000 1 Xabc"
    yield "exabyte.inr", (b"#INRIMAGE-4#{\nXDIM=1048576\nYDIM=1048576\nZDIM=1048576\nVDIM=1\nTYPE=float\nPIXSIZE=64 bits\nCPU=decm\n" + b"\n" * 256)[:252] + b"##}\n"
    yield "header without end.inr", b"#INRIMAGE-4#{\n" + b"\n" * 2 * MI
    yield "counts past 64 bits.dx", b"object 1 class array type float rank 0 items 18446744073709551615 data follows\n1 2 3\n"
    yield "a tebibyte of text.dx", b"object 1 class array type float rank 0 items 1099511627776 data follows\n" + b"1 " * 500
    yield "object that is its own part.dx", b'object 1 class field\ncomponent "data" value 1\ncomponent "positions" value 1\nend\n'
    yield "a hundred thousand objects.dx", b"".join(b"object %d class gridconnections counts 2 2 2\n" % i for i in range(100000)) + b"end\n"
    yield "rank 32.dx", b"object 1 class array type float rank 32 shape " + b"2 " * 32 + b"items 2 data follows\n1 2\n"


def vtk_cases():
    vti = ('<VTKFile type="ImageData" byte_order="LittleEndian" header_type="{header}"{more}><ImageData WholeExtent="{extent}"><Piece Extent="{extent}"><PointData Scalars="a">'
           '<DataArray type="UInt8" Name="a" format="{form}"{at}>{text}</DataArray></PointData></Piece></ImageData>{after}</VTKFile>')
    plain = {"header": "UInt32", "more": "", "extent": "0 3 0 3 0 3", "form": "appended", "at": ' offset="0"', "text": "", "after": '<AppendedData encoding="raw">_%s</AppendedData>'}
    good = (struct.pack("<I", 64) + bytes(64)).decode("latin-1")

    def made(data=good, **changes):
        return (vti.format(**{**plain, **changes}) % data).encode("latin-1")

    yield "extent past 64 bits.vti", made(extent="0 1048575 0 1048575 0 1048575")
    yield "extent of 2^63.vti", made(extent="-9223372036854775808 9223372036854775807 0 3 0 3")
    yield "extent backwards.vti", made(extent="3 0 3 0 3 0")
    yield "offset of an exabyte.vti", made(at=' offset="1152921504606846976"')
    yield "offset below zero.vti", made(at=' offset="-1"')
    yield "block of 4 GiB.vti", made(struct.pack("<I", 2**32 - 1).decode("latin-1") + good)
    yield "block of 2^64.vti", made(b"\xff".decode("latin-1") * 8 + good, header="UInt64")
    many = struct.pack("<3Q", 2**61, 2**20, 0).decode("latin-1")
    yield "2^61 packed blocks.vti", made(many, header="UInt64", more=' compressor="vtkZLibDataCompressor"')
    large = struct.pack("<4I", 1, 2**32 - 1, 0, 20).decode("latin-1") + zlib.compress(bytes(64)).decode("latin-1")
    yield "packed block of 4 GiB.vti", made(large, more=' compressor="vtkZLibDataCompressor"')
    squeezed = zeros_deflate(b"", 64, 15)
    yield "64 MiB in a block of 64 bytes.vti", made((struct.pack("<4I", 1, 64, 0, len(squeezed)) + squeezed).decode("latin-1"), more=' compressor="vtkZLibDataCompressor"')
    yield "elements nested 100000 deep.vti", b'<VTKFile type="ImageData"><ImageData WholeExtent="0 3 0 3 0 3">' + b"<a>" * 100000
    yield "a name of 8 MiB.vti", b'<VTKFile type="ImageData"><ImageData WholeExtent="0 3 0 3 0 3"><' + b"a" * 8 * MI
    yield "an attribute of 8 MiB.vti", b'<VTKFile type="ImageData"><ImageData WholeExtent="' + b"0 " * 4 * MI
    yield "a million attributes.vti", b"<VTKFile " + b"".join(b'a%d="" ' % i for i in range(300000)) + b">"
    laughs = b"".join(b'<!ENTITY %c "%s">' % (b, b"&%c;" % a * 10) for a, b in zip(b"abcdefgh", b"bcdefghi"))
    yield "entities that grow.vti", b'<!DOCTYPE x [<!ENTITY a "ha">' + laughs + b"]>" + made(text="&i;", form="ascii", at="", after="%s")
    vtk = "# vtk DataFile Version 3.0\nt\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS {}\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA {}\nSCALARS a {} 1\nLOOKUP_TABLE default\n"
    yield "dimensions past 64 bits.vtk", vtk.format("BINARY", "1048576 1048576 1048576", 2**60, "double").encode() + bytes(64)
    yield "points that wrap to few.vtk", vtk.format("BINARY", "4294967296 4294967296 1", 0, "float").encode() + bytes(64)
    yield "dimensions below zero.vtk", vtk.format("ASCII", "-4 -4 4", 64, "float").encode() + b"1 " * 64
    yield "lookup table of 2^40.vtk", vtk.format("BINARY", "4 4 4", 64, "float").replace("default", "a").encode() + bytes(256) + b"LOOKUP_TABLE a 1099511627776\n"
    yield "field of 2^62 by 2^62.vtk", vtk.format("BINARY", "4 4 4", 64, "float").split("SCALARS")[0].encode() + b"FIELD f 1\na 4611686018427387904 4611686018427387904 float\n"


# Bombs ----------------------------------------------------------------------------------------------------------------

@functools.lru_cache(None)
def zeros_deflate(before, n, bits):
    """Deflate data of `before` and n MiB of zeros, bare (bits -15), of zlib (15) or of gzip (31). After a full flush each MiB
    is the same bytes again, packed but once."""
    squeeze = zlib.compressobj(9, zlib.DEFLATED, -15)
    head = squeeze.compress(before) + squeeze.flush(zlib.Z_FULL_FLUSH)
    body = (squeeze.compress(bytes(MI)) + squeeze.flush(zlib.Z_FULL_FLUSH)) * n + squeeze.flush()
    if bits == -15:
        return head + body
    if bits == 15:
        high, low = divmod(zlib.adler32(before), 65536)  # zeros leave the sum, and add it to the sum of sums
        return b"\x78\xda" + head + body + struct.pack(">2H", (high + low * n * MI) % 65521, low)
    check, piece = zlib.crc32(before), bytes(MI)
    for _ in range(n):
        check = zlib.crc32(piece, check)
    return b"\x1f\x8b\x08" + bytes(6) + b"\xff" + head + body + struct.pack("<II", check, (len(before) + n * MI) % 2**32)


def zeros_zstd(n, declared=None):
    """A frame of run-length blocks: 4 bytes become 131072. The size may be declared, rightly or not."""
    window = 0x58  # 2 MiB
    header = b"\x28\xb5\x2f\xfd" + (bytes([0x00, window]) if declared is None else bytes([0xc0, window]) + struct.pack("<Q", declared))
    block = struct.pack("<I", 131072 << 3 | 1 << 1)[:3] + b"\0"
    last = struct.pack("<I", 131072 << 3 | 1 << 1 | 1)[:3] + b"\0"
    return header + block * (n // 131072 - 1) + last


def bombs():
    giga = zeros_deflate(b"", 1024, 31)
    yield "gzip of a gibibyte of nothing.nrrd.gz", giga
    yield "gzip in gzip.nrrd.gz", gzip.compress(giga, mtime=0)
    yield "gzip in gzip in gzip.nii.gz", gzip.compress(gzip.compress(giga, mtime=0), mtime=0)
    yield "gzip members without end.nii.gz", gzip.compress(b"", mtime=0) * 100000
    yield "header line of 256 MiB in gzip.nrrd.gz", zeros_deflate(b"NRRD0004\n#", 256, 31)
    yield "bzip2 of a gibibyte.nrrd.bz2", bz2.compress(b"NRRD0004\n") + bz2.compress(bytes(32 * MI)) * 32
    yield "zstd 32768 to 1.nrrd.zst", zeros_zstd(64 << 30)
    yield "zstd that declares 2^60.nii.zst", zeros_zstd(8 << 30, 2**60)
    yield "zstd that declares little.nii.zst", zeros_zstd(8 << 30, 10)
    yield "zstd with a window of 2 GiB.nrrd.zst", b"\x28\xb5\x2f\xfd\x00\xb0" + bytes(100)
    yield "data expand 1000 to 1 beyond the header.nrrd", nrrd([4, 4, 4], "gzip", data=giga)
    wrong = giga[:-8] + bytes(4) + giga[-4:]
    yield "a gibibyte with a wrong sum.nrrd", nrrd([1024, 1024, 1024], "gzip", data=wrong)
    wrong = zeros_deflate(b"", 192, 31)
    wrong = wrong[:-8] + bytes(4) + wrong[-4:]
    yield "192 MiB with a wrong sum.mha", (
        f"ObjectType = Image\nNDims = 3\nDimSize = 1024 1024 192\nElementType = MET_UCHAR\nCompressedData = True\n"
        f"CompressedDataSize = {len(wrong)}\nElementDataFile = LOCAL\n".encode() + wrong)
    outer = zeros_deflate(nrrd([512, 512, 1024], data=b""), 256, 31)
    yield "256 MiB with a wrong sum around a header.nrrd.gz", outer[:-8] + bytes(4) + outer[-4:]
    yield "gzip data too short.nrrd", nrrd([256, 256, 256], "gzip", data=zeros_deflate(b"", 1, 31))
    yield "gzip data broken in the middle.nrrd", nrrd([64, 64, 64], "gzip", data=gzip.compress(bytes(64**3))[:60] + b"\xff" * 400)
    yield "bzip2 data broken.nrrd", nrrd([64, 64, 64], "bzip2", data=bz2.compress(bytes(64**3))[:20] + b"\xff" * 100)


# DICOM ----------------------------------------------------------------------------------------------------------------

def element(group, number, vr, value):
    if vr in (b"OB", b"OW", b"SQ", b"UN", b"UT"):
        return struct.pack("<HH", group, number) + vr + struct.pack("<HI", 0, len(value)) + value
    return struct.pack("<HH", group, number) + vr + struct.pack("<H", len(value)) + value


def dicom(body, syntax=b"1.2.840.10008.1.2.1\0"):
    meta = element(2, 2, b"UI", b"1.2.840.10008.5.1.4.1.1.2\0") + element(2, 3, b"UI", b"1.2\0") + element(2, 0x10, b"UI", syntax)
    return bytes(128) + b"DICM" + element(2, 0, b"UL", struct.pack("<I", len(meta))) + meta + body


def image_elements(rows=4, columns=4, frames=None, pixels=bytes(16)):
    body = element(8, 0x16, b"UI", b"1.2.840.10008.5.1.4.1.1.2\0") + element(0x20, 0xd, b"UI", b"1.3\0") + element(0x20, 0xe, b"UI", b"1.4\0")
    body += element(0x28, 2, b"US", struct.pack("<H", 1)) + element(0x28, 4, b"CS", b"MONOCHROME2 ")
    if frames is not None:
        body += element(0x28, 8, b"IS", frames)
    for number, value in ((0x10, rows), (0x11, columns), (0x100, 8), (0x101, 8), (0x102, 7), (0x103, 0)):
        body += element(0x28, number, b"US", struct.pack("<H", value))
    return body + element(0x7fe0, 0x10, b"OB", pixels)


def dicom_cases():
    huge = struct.pack("<HH", 0x10, 0x10) + b"UN" + struct.pack("<HI", 0, 0xfffffff0)
    yield "value length of 4 GiB.dcm", dicom(huge)
    yield "value length of 4 GiB in pixels.dcm", dicom(image_elements()[:-24] + struct.pack("<HH", 0x7fe0, 0x10) + b"OB" + struct.pack("<HI", 0, 0xfffffffe))
    yield "implicit value length of 4 GiB.dcm", dicom(struct.pack("<HHI", 0x10, 0x10, 0xfffffff0), b"1.2.840.10008.1.2\0")
    yield "two thousand million frames.dcm", dicom(image_elements(frames=b"2147483646"))
    yield "negative frames.dcm", dicom(image_elements(frames=b"-5"))
    yield "65535 x 65535 of 16 bytes.dcm", dicom(image_elements(65535, 65535))
    item = struct.pack("<HHI", 0xfffe, 0xe000, 0xffffffff)
    nested = (struct.pack("<HH", 0x40, 0xa730) + b"SQ" + struct.pack("<HI", 0, 0xffffffff) + item) * 20000
    yield "sequences nested 20000 deep.dcm", dicom(nested)
    fragments = struct.pack("<HH", 0x7fe0, 0x10) + b"OB" + struct.pack("<HI", 0, 0xffffffff) + item[:4] + struct.pack("<I", 0)
    yield "fragment of 4 GiB.dcm", dicom(image_elements()[:-24] + fragments + item[:4] + struct.pack("<I", 0xfffffff0), b"1.2.840.10008.1.2.4.50")
    yield "deflated data set of 512 MiB.dcm", dicom(zeros_deflate(image_elements()[:-28], 512, -15), b"1.2.840.10008.1.2.1.99")
    pixels = struct.pack("<HH", 0x7fe0, 0x10) + b"OB" + struct.pack("<HI", 0, 512 * MI)
    yield "deflated pixels of 512 MiB where 16 bytes belong.dcm", dicom(zeros_deflate(image_elements()[:-28] + pixels, 512, -15), b"1.2.840.10008.1.2.1.99")
    blob = struct.pack("<HH", 9, 0x1010) + b"OB" + struct.pack("<HI", 0, 512 * MI)
    yield "deflated private element of 512 MiB.dcm", dicom(zeros_deflate(blob, 512, -15), b"1.2.840.10008.1.2.1.99")
    table = fragments[:-4] + struct.pack("<I", 0xfffffff0)
    yield "offset table of 4 GiB.dcm", dicom(image_elements(frames=b"2 ")[:-28] + table + bytes(64), b"1.2.840.10008.1.2.4.50")
    tiny = item[:4] + struct.pack("<I", 0)
    yield "a hundred thousand empty fragments.dcm", dicom(image_elements(frames=b"100000")[:-28] + fragments + tiny * 100000, b"1.2.840.10008.1.2.4.50")
    yield "RLE whose segments lie elsewhere.dcm", dicom(image_elements()[:-28] + fragments + item[:4] + struct.pack("<I", 80) + struct.pack("<16I", 15, *[2**32 - 1] * 15) + bytes(16),
                                                        b"1.2.840.10008.1.2.5")
    yield "RLE that grows.dcm", dicom(image_elements(65535, 65535)[:-28] + fragments + item[:4] + struct.pack("<I", 80) + struct.pack("<16I", 1, 64, *[0] * 14) + b"\x81\0" * 8,
                                      b"1.2.840.10008.1.2.5")
    yield "list of files elsewhere.dcm", dicom(element(4, 0x1130, b"CS", b"A ") + struct.pack("<HH", 4, 0x1220) + b"SQ" + struct.pack("<HI", 0, 0xffffffff) + item
                                               + element(4, 0x1500, b"CS", b"..\\..\\etc\\passwd"))
    yield "nothing after DICM.dcm", bytes(128) + b"DICM"
    yield "meta group that says 4 GiB.dcm", bytes(128) + b"DICM" + element(2, 0, b"UL", struct.pack("<I", 0xffffffff))


# TIFF -----------------------------------------------------------------------------------------------------------------

def tiff(entries, after=0, data=b"", big=False):
    """One directory at byte 8; entries (tag, type, count, value)."""
    at = 8
    n = len(entries)
    head = b"II*\0" + struct.pack("<I", at)
    body = struct.pack("<H", n) + b"".join(struct.pack("<HHII", *e) for e in sorted(entries)) + struct.pack("<I", after)
    return head + body + data


def page(width=4, height=4, offset=200, n_bytes=16, compression=1, more=()):
    return [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 8), (259, 3, 1, compression), (262, 3, 1, 1), (273, 4, 1, offset),
            (277, 3, 1, 1), (278, 4, 1, height), (279, 4, 1, n_bytes)] + list(more)


def tiff_cases():
    yield "directory that is its own next.tif", tiff(page(), after=8, data=bytes(400))
    yield "4294967295 wide and high.tif", tiff(page(2**32 - 1, 2**32 - 1), data=bytes(400))
    yield "a million wide and high, 16 bytes.tif", tiff(page(2**20, 2**20), data=bytes(400))
    yield "strip of 4 GiB.tif", tiff(page(n_bytes=2**32 - 1), data=bytes(400))
    yield "strip past the end.tif", tiff(page(offset=2**31), data=bytes(400))
    yield "four thousand million strips.tif", tiff([(256, 4, 1, 4), (257, 4, 1, 2**31), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1),
                                                    (273, 4, 2**32 - 1, 8), (277, 3, 1, 1), (278, 4, 1, 1), (279, 4, 2**32 - 1, 8)], data=bytes(400))
    squeezed = zeros_deflate(b"", 256, 15)
    yield "deflate strip of 256 MiB where 16 bytes belong.tif", tiff(page(offset=200, n_bytes=len(squeezed), compression=8), data=bytes(78) + squeezed)
    yield "65000 x 65000 from one deflate strip.tif", tiff(page(65000, 65000, 200, len(squeezed), 8), data=bytes(78) + squeezed)
    yield "LZW of garbage.tif", tiff(page(2000, 2000, 200, 4000, 5), data=b"\xff" * 5000)
    yield "rows per strip 0.tif", tiff([e for e in page() if e[0] != 278] + [(278, 4, 1, 0)], data=bytes(400))
    yield "0 x 0.tif", tiff(page(0, 0), data=bytes(400))
    yield "tiles of 0.tif", tiff(page(more=[(322, 4, 1, 0), (323, 4, 1, 0), (324, 4, 1, 200), (325, 4, 1, 16)]), data=bytes(400))
    yield "tiles of 2^31.tif", tiff(page(more=[(322, 4, 1, 2**31), (323, 4, 1, 2**31), (324, 4, 1, 200), (325, 4, 1, 16)]), data=bytes(400))
    yield "65535 samples a pixel.tif", tiff([e for e in page() if e[0] != 277] + [(277, 3, 1, 65535)], data=bytes(400))
    for bits in (0, 3, 65535):
        yield f"{bits} bits a sample.tif", tiff([e for e in page() if e[0] != 258] + [(258, 3, 1, bits)], data=bytes(400))
    yield "planes of 65535 samples.tif", tiff([e for e in page() if e[0] != 277] + [(277, 3, 1, 65535), (284, 3, 1, 2)], data=bytes(400))
    yield "predictor of floats for bytes.tif", tiff(page(compression=8, more=[(317, 3, 1, 3)]), data=bytes(400))
    yield "predictor 99.tif", tiff(page(compression=5, more=[(317, 3, 1, 99)]), data=bytes(400))
    for code, name in ((3, "fax"), (6, "old JPEG"), (7, "JPEG"), (34712, "JPEG 2000"), (34887, "LERC"), (34925, "LZMA"), (50000, "zstd"), (50001, "WebP"), (32773, "PackBits")):
        yield f"{name} of garbage.tif", tiff(page(64, 64, 200, 300, code), data=b"\x9d\xff\xd8\xe7" * 200)
    yield "strip offsets that lie in themselves.tif", tiff([e for e in page() if e[0] not in (273, 279)] + [(273, 4, 4, 8), (279, 4, 4, 8)], data=bytes(400))
    yield "type of field 77.tif", tiff(page() + [(270, 77, 4, 8)], data=bytes(400))
    yield "text of 4 GiB.tif", tiff(page(more=[(270, 2, 2**32 - 1, 8)]), data=bytes(400))
    yield "directory at 2^63.tif", b"II+\0" + struct.pack("<HHQ", 8, 0, 2**63)
    yield "directory of 2^64 entries.tif", b"II+\0" + struct.pack("<HHQQ", 8, 0, 16, 2**64 - 1) + bytes(400)
    ome = '<OME><Image ID="Image:0"><Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint8" SizeX="4" SizeY="4" SizeZ="{}" SizeC="{}" SizeT="{}">{}</Pixels></Image></OME>'
    for what, text in (("2^31 planes", ome.format(2**31, 1, 1, "<TiffData/>")), ("planes past 64 bits", ome.format(2**20, 2**20, 2**20, "<TiffData/>")),
                       ("two hundred thousand files", ome.format(4, 1, 1, "".join(f'<TiffData IFD="0"><UUID FileName="f{i}.tif">u</UUID></TiffData>' for i in range(200000)))),
                       ("elements 50000 deep", ome.format(1, 1, 1, "<a>" * 50000)), ("a companion that is itself", '<OME><BinaryOnly MetadataFile="OME of a companion that is itself.ome.tif"/></OME>')):
        yield f"OME of {what}.ome.tif", tiff(page(more=[(270, 2, len(text) + 1, 8 + 2 + 12 * 10 + 4 + 400)]), data=bytes(400) + text.encode() + b"\0")
    yield "ImageJ says two thousand million slices.tif", tiff(page(more=[(270, 2, 60, 160)]), data=bytes(30) + b"ImageJ=1.53\nimages=2000000000\nslices=2000000000\n\0" + bytes(300))
    chain = b"".join(struct.pack("<H", 0) + struct.pack("<I", 8 + 6 * (i + 1)) for i in range(100000))
    yield "a hundred thousand empty directories.tif", b"II*\0" + struct.pack("<I", 8) + chain + struct.pack("<HI", 0, 0)
    same = b"II*\0" + struct.pack("<I", 8)
    directory = struct.pack("<H", 9) + b"".join(struct.pack("<HHII", *e) for e in sorted(page(2**16, 2**15, 8, 400)))
    yield "five thousand large pages of the same bytes.tif", same + b"".join(
        directory + struct.pack("<I", 8 + (len(directory) + 4) * (i + 1)) for i in range(5000)) + directory + bytes(404)


# HDF5 -----------------------------------------------------------------------------------------------------------------

def hdf5_cases(folder):
    import h5py
    import numpy as np

    def made(name, build, user_block=0):
        path = f"{folder}/made.h5"
        with h5py.File(path, "w", libver="latest") as file:
            build(file)
        with open(path, "rb") as file:
            return name, file.read()

    yield made("an exabyte that is nowhere.h5", lambda f: f.create_dataset("v", (2**20, 2**20, 2**20), "u1", chunks=(64, 64, 64)))
    yield made("128 MiB of fill value and nothing stored.h5", lambda f: f.create_dataset("v", (512, 512, 512), "u1", chunks=(64, 64, 64), fillvalue=7))
    def squeezed(file):
        dataset = file.create_dataset("v", (256, 1024, 1024), "u1", chunks=(256, 1024, 1024), compression="gzip", compression_opts=9)
        dataset.id.write_direct_chunk((0, 0, 0), zeros_deflate(b"", 256, 15))

    yield made("chunk of 256 MiB from 256 KiB.h5", squeezed)
    yield made("groups nested 5000 deep.h5", lambda f: f.create_group("/".join(["g"] * 5000)).create_dataset("v", (4, 4, 4), "u1"))

    def ring(file):
        file["a"] = h5py.SoftLink("/b")
        file["b"] = h5py.SoftLink("/a")
        group = file.create_group("g")
        group["up"] = file["/"]
        group["self"] = group

    yield made("links in a ring.h5", ring)
    yield made("link into another file.h5", lambda f: f.__setitem__("v", h5py.ExternalLink("/etc/passwd", "/v")))

    def outside(file):
        file.create_dataset("v", (8, 8, 8), "u1", external=[("/etc/passwd", 0, 512)])

    yield made("samples that lie in a file elsewhere.h5", outside)

    def virtual(file):
        layout = h5py.VirtualLayout((8, 8, 8), "u1")
        layout[:] = h5py.VirtualSource("/etc/passwd", "v", (8, 8, 8))
        file.create_virtual_dataset("v", layout)

    yield made("a view of a data set elsewhere.h5", virtual)
    def minc(file):
        for axis in "xyz":
            file.create_dataset(f"minc-2.0/dimensions/{axis}space", data=0.0).attrs.update({"start": 0.0, "step": 1.0})
        image = file.create_dataset("minc-2.0/image/0/image", data=np.zeros((4, 4, 4), "u1"))
        image.attrs["dimorder"] = np.bytes_("zspace,yspace,xspace")
        for name in ("min", "max"):
            file.create_dataset(f"minc-2.0/image/0/image-{name}", (4,), "f8", external=[("/dev/zero", 0, 32)])

    yield made("ends that lie on a device.mnc", minc)
    yield made("no data set at all.h5", lambda f: f.create_group("g"))
    yield made("33 axes is too many, 32 is there.h5", lambda f: f.create_dataset("v", (1,) * 32, "u1"))
    yield made("an attribute of 60 KB that is no text.h5", lambda f: f.create_dataset("v", (7, 6, 5), "u1").attrs.__setitem__("a", np.arange(60000, dtype="u1")))
    name, good = made("", lambda f: f.create_dataset("v", data=np.arange(4096, dtype="u1").reshape(16, 16, 16), chunks=(8, 8, 8), compression="gzip"))
    yield "cut in the middle.h5", good[:len(good) // 2]
    yield "signature alone.h5", good[:8]
    yield "superblock of ones.h5", good[:8] + b"\xff" * 200
    for k in range(24):
        at = 8 + k * 97 % (len(good) - 16)
        yield f"eight bytes of ones at {at}.h5", good[:at] + b"\xff" * 8 + good[at + 8:]


# Folders: names with a slash ------------------------------------------------------------------------------------------

def zarr2(name, chunk=None, key="0.0.0", **changes):
    about = {"zarr_format": 2, "shape": [4, 4, 4], "chunks": [4, 4, 4], "dtype": "|u1", "compressor": None, "fill_value": 0, "order": "C", "filters": None}
    yield f"{name}.zarr/.zarray", json.dumps({**about, **changes}).encode()
    if chunk is not None:
        yield f"{name}.zarr/{key}", chunk


def zarr3(name, chunk, codecs, **changes):
    about = {"zarr_format": 3, "node_type": "array", "shape": [4, 4, 4], "data_type": "uint8", "fill_value": 0, "attributes": {}, "codecs": codecs,
             "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [4, 4, 4]}}, "chunk_key_encoding": {"name": "default"}}
    yield f"{name}.zarr/zarr.json", json.dumps({**about, **changes}).encode()
    yield f"{name}.zarr/c/0/0/0", chunk


def folders():
    giga = zeros_deflate(b"", 1024, 31)
    yield from zarr2("an exabyte", shape=[2**20] * 3, chunks=[2**20] * 3, dtype="<f8")
    yield from zarr2("2^60 chunks", shape=[2**20] * 3, chunks=[1, 1, 1])
    yield from zarr2("2^63 samples along an axis", shape=[2**63, 4, 4])
    yield from zarr2("negative shape", shape=[-4, -4, 4])
    yield from zarr2("chunks of 0", chunks=[0, 0, 0])
    yield from zarr2("chunk of 2^40", b"", shape=[4, 4, 4], chunks=[2**20, 2**20, 1])
    yield from zarr2("a thousand axes", shape=[1] * 1000, chunks=[1] * 1000)
    yield from zarr2("type of 2^31 bytes", b"", dtype="|S2147483647")
    yield from zarr2("gibibyte in a chunk of 64 bytes", giga, compressor={"id": "gzip", "level": 1})
    yield from zarr2("zlib gibibyte in a chunk of 64 bytes", zeros_deflate(b"", 64, 15), compressor={"id": "zlib", "level": 1})
    yield from zarr2("zstd that says 2^60", zeros_zstd(1 << 30, 2**60), compressor={"id": "zstd", "level": 1})
    yield from zarr2("lz4 that says 2 GiB", struct.pack("<I", 2**31 - 1) + b"\x1f\0\1\0" + b"\xff" * 1000, compressor={"id": "lz4"})
    for what, head in (("2 GiB", (2, 1, 1, 1, 2**31 - 1, 64, 32)), ("blocks of 0", (2, 1, 1, 1, 64, 0, 32)), ("no bytes", (2, 1, 1, 1, 0, 0, 0)),
                       ("blocks that lie past it", (2, 1, 1, 1, 64, 4, 24)), ("version 200", (200, 1, 255, 255, 64, 64, 32))):
        yield from zarr2(f"blosc of {what}", struct.pack("<4B3I", *head) + b"\xff" * 40, compressor={"id": "blosc", "cname": "lz4", "clevel": 5, "shuffle": 1, "blocksize": 0})
    yield from zarr2("filters a thousand deep", bytes(64), filters=[{"id": "shuffle", "elementsize": 1}] * 1000)
    yield from zarr2("shuffle of 2^31", bytes(64), filters=[{"id": "shuffle", "elementsize": 2**31 - 1}])
    yield "nested 100000 deep.zarr/.zarray", b"[" * 100000
    yield "text of 20 MiB.zarr/.zarray", b'{"zarr_format": 2, "a": "' + b"x" * (20 * MI) + b'"}'
    yield "a hundred thousand keys.zarr/.zattrs", b"{" + b",".join(b'"k%d": 1' % i for i in range(100000)) + b"}"
    yield "a hundred thousand keys.zarr/.zgroup", b'{"zarr_format": 2}'
    yield "a group of itself.zarr/.zgroup", b'{"zarr_format": 2}'
    yield "a group of itself.zarr/.zattrs", json.dumps({"multiscales": [{"version": "0.4", "axes": [{"name": n} for n in "zyx"], "datasets": [{"path": "."}] * 1000}]}).encode()
    shard = [{"name": "sharding_indexed", "configuration": {"chunk_shape": [2, 2, 2], "codecs": [{"name": "bytes"}], "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}]}}]
    yield from zarr3("pieces that lie past the shard", struct.pack("<16Q", *[2**63, 2**63] * 8), shard)
    yield from zarr3("pieces on each other", bytes(8) + struct.pack("<16Q", *[0, 8] * 8), shard)
    yield from zarr3("a piece that is the index", struct.pack("<16Q", *[0, 128] * 8), shard)
    deep = [{"name": "bytes"}]
    for _ in range(40):
        deep = [{"name": "sharding_indexed", "configuration": {"chunk_shape": [4, 4, 4], "codecs": deep, "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}]}}]
    yield from zarr3("shards in shards 40 deep", struct.pack("<2Q", 0, 16) * 41, deep)
    yield from zarr3("shard of 2^60 pieces", bytes(64), shard, shape=[2**20] * 3, chunk_grid={"name": "regular", "configuration": {"chunk_shape": [2**20] * 3}})
    yield from zarr3("transposed beyond its axes", bytes(64), [{"name": "transpose", "configuration": {"order": [7, 0, 2**31]}}, {"name": "bytes"}])
    for n in (0, 2**31, 2**63 - 1, 2**64 - 1):
        yield f"numbers far apart/s{n:020}.tif", tiff(page(), data=bytes(400))
    for name in ("s#", "s1", "s#1", "s1#", "s*", "s4"):
        yield f"names that look like patterns/{name}.tif", tiff(page(), data=bytes(400))
    for i in range(3):
        yield f"pages of 2^31 rows/s{i}.tif", tiff(page(2**31, 2**31), data=bytes(400))
        yield f"slices of 65535 x 65535/{i}.dcm", dicom(image_elements(65535, 65535))
        yield f"slices that are deflated bombs/{i}.dcm", dicom(zeros_deflate(image_elements()[:-28], 512, -15), b"1.2.840.10008.1.2.1.99")
        yield f"pictures of 2^31/s{i}.png", png(2**31 - 1, 2**31 - 1, b"")
        yield f"pictures that are bombs/s{i}.png", png(30000, 30000, zeros_deflate(b"", 64, 15))
    for i in range(400):
        yield f"a thousand million frames each/{i}.dcm", dicom(image_elements(frames=b"1000000000"))
        yield f"places that are no numbers/{i}.dcm", dicom(element(0x20, 0x32, b"DS", b"nan\\inf\\1e400 ") + image_elements())


def png(width, height, squeezed):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 0, 0, 0, 0)) + chunk(b"IDAT", squeezed) + chunk(b"IEND", b"")


def cases(folder):
    yield from plain_headers()
    yield from more_headers()
    yield from vtk_cases()
    yield from folders()
    yield from bombs()
    yield from dicom_cases()
    yield from tiff_cases()
    try:
        yield from hdf5_cases(folder)
    except ImportError:
        pass


# The sizes that a file has which may be read, whole or in part, since it holds what it says; all others are refused.
READ = {
    "chunk of 256 MiB from 256 KiB.h5": (1024, 1024, 256),
    "ImageJ says two thousand million slices.tif": (4, 4, 1),
    "directory that is its own next.tif": (4, 4, 1),
    "strip of 4 GiB.tif": (4, 4, 1),
    "deflate strip of 256 MiB where 16 bytes belong.tif": (4, 4, 1),
    "data expand 1000 to 1 beyond the header.nrrd": (4, 4, 4),
    "data file is itself.nrrd": (4, 4, 4),
    "an attribute of 60 KB that is no text.h5": (5, 6, 7),
    "3 bits a sample.tif": (4, 4, 1),
    "PackBits of garbage.tif": (64, 64, 1),
    "text of 4 GiB.tif": (4, 4, 1),
    "type of field 77.tif": (4, 4, 1),
    "deflated pixels of 512 MiB where 16 bytes belong.dcm": (4, 4, 1),
    "ends that lie on a device.mnc": (4, 4, 4),
    "inflates to a gibibyte.mha": (4, 4, 4),
    "numbers far apart": (4, 4, 4),
    "names that look like patterns": (4, 4, 2),
    "places that are no numbers": (4, 4, 400),
    "offset of values 3e38.nii": (2, 2, 2),
    "slope 3e38.nii": (2, 2, 2),
    "slope infinite.nii": (2, 2, 2),  # as NIfTI's own library: no slope
    "slope nan.nii": (2, 2, 2),
}


def sizes_when_read(name):
    """None where a file must be refused."""
    if name.endswith(".nii") and name.split()[0] in ("matrix", "quaternion", "range", "shift", "step"):
        return 2, 2, 2  # what is no number is told and not used
    return (16, 16, 16) if name.startswith("eight bytes of ones at ") else READ.get(name)


def main():
    """Writes every file into a folder; the program that measures stays small."""
    folder = sys.argv[1]
    for name, data in cases(folder):
        os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)
    if os.path.exists(os.path.join(folder, "made.h5")):
        os.unlink(os.path.join(folder, "made.h5"))


if __name__ == "__main__":
    main()
