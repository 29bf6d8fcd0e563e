#!/usr/bin/python3
"""VTK at the work of bench/surfaces. Needs an X display for `draw`.

    peer_surfaces.py contour|draw|histogram|mass VOLUME.nrrd VALUE THREADS

Prints one JSON line when it is ready; then, for each number N read from standard input, does the work N times and
prints their seconds as a JSON list.

contour    vtkFlyingEdges3D with normals, from samples in memory to the mesh
draw       vtkPolyDataMapper on Mesa's software rasteriser, 1024 x 1024, no anti-aliasing, 3 degrees a frame
histogram  vtkImageHistogramStatistics: histogram, mean, deviation, median
mass       vtkMassProperties: area and volume of the mesh
"""
import json
import math
import os
import sys
import time

WHAT, PATH, VALUE, THREADS = sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4])
os.environ["LP_NUM_THREADS"] = os.environ["VTK_SMP_MAX_THREADS"] = str(THREADS)

import vtk

import peer_vtk


def contour_of(image, normals):
    contour = vtk.vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, VALUE)
    contour.SetComputeNormals(normals)
    contour.ComputeScalarsOff()
    contour.Update()
    return contour


def window_of(mesh, n):
    mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
    mapper.SetInputData(mesh)
    mapper.ScalarVisibilityOff()
    actor.SetMapper(mapper)
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    renderer.AddActor(actor)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(1024, 1024)
    window.AddRenderer(renderer)
    camera, middle = renderer.GetActiveCamera(), (n - 1) / 2
    camera.SetFocalPoint(middle, middle, middle)
    camera.SetPosition(middle, middle, middle + middle * math.sqrt(3) / math.sin(math.radians(15)))
    camera.SetViewAngle(20)
    camera.Azimuth(30)
    camera.Elevation(20)
    renderer.ResetCameraClippingRange()
    return window, camera


def work():
    """What is timed."""
    image = peer_vtk.image_of(peer_vtk.read_nrrd(PATH))
    if WHAT == "contour":
        step = contour_of(image, True)
    elif WHAT == "mass":
        step = vtk.vtkMassProperties()
        step.SetInputData(contour_of(image, False).GetOutput())
    elif WHAT == "histogram":
        step = vtk.vtkImageHistogramStatistics()
        step.SetInputData(image)
        step.SetNumberOfThreads(THREADS)
        step.GenerateHistogramImageOff()
    else:
        window, camera = window_of(contour_of(image, True).GetOutput(), image.GetDimensions()[0])

        def frame():
            camera.Azimuth(3)
            window.Render()
            window.WaitForCompletion()
        return frame

    def again():
        step.Modified()
        step.Update()
    return again


def main():
    once = work()
    once()
    print(json.dumps({"version": vtk.vtkVersion().GetVTKVersion()}), flush=True)
    for line in sys.stdin:
        seconds = []
        for _ in range(int(line)):
            began = time.perf_counter()
            once()
            seconds.append(time.perf_counter() - began)
        print(json.dumps(seconds), flush=True)


main()
