"""A Zarr 2 array of chunks of 64 x 64 x 64 from raw samples of u16: make_zarr.py RAW FOLDER N lz4|zstd|gzip"""
import sys

import numcodecs
import numpy as np
import zarr


def main():
    source, folder, n, packed = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
    samples = np.fromfile(source, dtype="<u2").reshape(n, n, n)
    compressor = {"lz4": numcodecs.Blosc("lz4", 5, 1), "zstd": numcodecs.Zstd(3), "gzip": numcodecs.GZip(5)}[packed]
    zarr.array(samples, store=zarr.DirectoryStore(folder), chunks=(64, 64, 64), compressor=compressor)


if __name__ == "__main__":
    main()
