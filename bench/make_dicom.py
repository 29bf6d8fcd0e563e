"""A folder of DICOM slices from an n^3 volume of u16: make_dicom.py RAW FOLDER N plain|rle. Names are out of order."""
import os
import sys

import numpy as np
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import CTImageStorage, ExplicitVRLittleEndian, RLELossless, generate_uid


def write_dicom(source, folder, n, packed):
    volume = np.fromfile(source, dtype="<u2").reshape(n, n, n)
    series, study, frame = generate_uid(), generate_uid(), generate_uid()
    os.makedirs(folder + ".part", exist_ok=True)
    for k in range(n):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = CTImageStorage
        meta.MediaStorageSOPInstanceUID = generate_uid()
        meta.TransferSyntaxUID = ExplicitVRLittleEndian
        image = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        image.SOPClassUID, image.SOPInstanceUID = CTImageStorage, meta.MediaStorageSOPInstanceUID
        image.SeriesInstanceUID, image.StudyInstanceUID, image.FrameOfReferenceUID = series, study, frame
        image.Modality, image.InstanceNumber = "CT", k + 1
        image.ImageOrientationPatient, image.ImagePositionPatient = [1, 0, 0, 0, 1, 0], [0, 0, k * 0.5]
        image.PixelSpacing, image.SliceThickness = [0.5, 0.5], 0.5
        image.Rows = image.Columns = n
        image.SamplesPerPixel, image.PhotometricInterpretation, image.PixelRepresentation = 1, "MONOCHROME2", 0
        image.BitsAllocated = image.BitsStored = 16
        image.HighBit = 15
        image.is_little_endian, image.is_implicit_VR = True, False
        image.PixelData = volume[k].tobytes()
        if packed:
            image.compress(RLELossless, volume[k])
        pydicom.dcmwrite(f"{folder}.part/slice{(k * 7919) % n:04d}.dcm", image, write_like_original=False)
    os.replace(folder + ".part", folder)


if __name__ == "__main__":
    write_dicom(sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4] == "rle")
