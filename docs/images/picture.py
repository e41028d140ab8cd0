"""Writes what a window of VTK shows."""
import os

import vtk


def write_png(window, name):
    """Writes the picture to a PNG file beside this script."""
    picture = vtk.vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(os.path.join(os.path.dirname(os.path.abspath(__file__)), name))
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()
