#!/usr/bin/python3
"""VTK's CPU ray caster (vtkFixedPointVolumeRayCastMapper) on one case of bench/cases.py. Needs an X display.

    peer_vtk.py VOLUME.nrrd MODE SHADED(0|1) STEP THREADS [PICTURE.png]

Prints one JSON line when the first frame is there ({"version", "first_s"}); then, for each number N read from standard
input, renders N frames and prints their seconds as a JSON list.
"""
import json
import sys
import time

import numpy
import vtk
from vtk.util import numpy_support

import cases


def read_nrrd(path):
    """The samples of an attached raw NRRD of bytes, [z][y][x]."""
    with open(path, "rb") as file:
        data = file.read()
    header, _ = data.split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in header.decode().split("\n")[1:])
    if fields["type"] != "uint8" or fields["encoding"] != "raw":
        sys.exit(f"{path}: expected raw uint8, found {fields['encoding']} {fields['type']}")
    sizes = [int(word) for word in fields["sizes"].split()]
    return numpy.frombuffer(data, numpy.uint8, offset=len(header) + 2).reshape(sizes[::-1])


def image_of(samples):
    image = vtk.vtkImageData()
    image.SetDimensions(*samples.shape[::-1])
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(samples.ravel(), deep=1))
    return image


def property_of(mode, shaded):
    color_rows, opacity_rows = cases.TRANSFER[mode]
    color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    for row in color_rows:
        color.AddRGBPoint(*row)
    for row in opacity_rows:
        opacity.AddPoint(*row)
    result = vtk.vtkVolumeProperty()
    result.SetColor(color)
    result.SetScalarOpacity(opacity)
    result.SetScalarOpacityUnitDistance(1.0)
    result.SetInterpolationTypeToLinear()
    result.SetShade(1 if shaded else 0)
    ambient, diffuse, specular, shininess = cases.SHADING
    result.SetAmbient(ambient)
    result.SetDiffuse(diffuse)
    result.SetSpecular(specular)
    result.SetSpecularPower(shininess)
    return result


def mapper_of(image, mode, step, threads):
    """One ray a pixel and the step that was asked for: nothing adapts to the time a frame takes."""
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetNumberOfThreads(threads)
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.LockSampleDistanceToInputSpacingOff()
    mapper.SetSampleDistance(step)
    mapper.SetInteractiveSampleDistance(step)
    mapper.SetImageSampleDistance(1)
    mapper.SetMinimumImageSampleDistance(1)
    mapper.SetMaximumImageSampleDistance(1)
    if mode == "mip":
        mapper.SetBlendModeToMaximumIntensity()
    mapper.SetInputData(image)
    return mapper


def window_of(volume, n):
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    renderer.AddVolume(volume)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(cases.SIZE, cases.SIZE)
    window.AddRenderer(renderer)
    eye, at, up = cases.camera(n)
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(*at)
    camera.SetPosition(*eye)
    camera.SetViewUp(*up)
    camera.SetViewAngle(cases.FOV_DEG)
    camera.OrthogonalizeViewUp()
    renderer.ResetCameraClippingRange()
    return window


def write_picture(window, path):
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetFileName(path)
    writer.Write()


def frame(window):
    start = time.perf_counter()
    window.Render()
    window.WaitForCompletion()
    return time.perf_counter() - start


def main(path, mode, shaded, step, threads, picture=None):
    samples = read_nrrd(path)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper_of(image_of(samples), mode, float(step), int(threads)))
    volume.SetProperty(property_of(mode, shaded == "1"))
    window = window_of(volume, samples.shape[0])
    first = frame(window)
    print(json.dumps({"version": "VTK " + vtk.vtkVersion().GetVTKVersion(), "first_s": first}), flush=True)
    if picture:
        write_picture(window, picture)
    for line in sys.stdin:
        print(json.dumps([frame(window) for _ in range(int(line))]), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
