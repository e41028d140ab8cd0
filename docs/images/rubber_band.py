#!/usr/bin/python3
"""Makes rubber_band.png of the gallery: /usr/bin/python3 docs/images/rubber_band.py RUN_DIRECTORY

The directory is that of a run of examples/scenes/rubber_band.toml. The band is drawn at the start, at
its greatest length and at the end, one below the other.
"""

import os
import sys
import xml.etree.ElementTree as ElementTree

import vtk

from picture import write_png
from spring import colour_bar, surface

SIZE = (1000, 400)
TOP_OF_RANGE = 3.0e6  # Pa
DISTANCE = 0.045  # m, between the bands


def frames(directory):
    """[(time, path)] of a run."""
    sets = ElementTree.parse(os.path.join(directory, "frames.pvd")).getroot().iter("DataSet")
    return [(float(s.get("timestep")), os.path.join(directory, s.get("file"))) for s in sets]


def deformed(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    warp = vtk.vtkWarpVector()
    warp.SetInputConnection(reader.GetOutputPort())
    warp.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "displacement")
    warp.Update()
    return warp


def label(text, place):
    actor = vtk.vtkBillboardTextActor3D()
    actor.SetInput(text)
    actor.SetPosition(*place)
    style = actor.GetTextProperty()
    style.SetFontFamilyToArial()
    style.SetFontSize(18)
    style.SetColor(0, 0, 0)
    return actor


def main(directory):
    found = [(time, deformed(path)) for time, path in frames(directory)]
    longest = max(found, key=lambda frame: frame[1].GetOutput().GetBounds()[1])
    colours = vtk.vtkColorTransferFunction()  # cool to warm
    colours.SetColorSpaceToDiverging()
    colours.AddRGBPoint(0.0, 0.23, 0.30, 0.75)
    colours.AddRGBPoint(TOP_OF_RANGE, 0.71, 0.02, 0.15)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for row, (time, warp) in enumerate((found[0], longest, found[-1])):
        mapper, actor = surface(warp, edges=True)
        mapper.SetScalarModeToUseCellFieldData()
        mapper.SelectColorArray("von_mises")
        mapper.SetLookupTable(colours)
        actor.SetPosition(0, -DISTANCE * row, 0)
        renderer.AddActor(actor)
        renderer.AddActor(label(f"t = {time:.3f} s", (0, -DISTANCE * row + 0.015, 0.01)))
    for actor in colour_bar(colours):
        renderer.AddActor2D(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetSize(*SIZE)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    length = longest[1].GetOutput().GetBounds()[1]
    middle = 0.62 * length
    camera.SetFocalPoint(middle, -0.8 * DISTANCE, 0)
    camera.SetPosition(middle + 0.1, 0.2, 1.0)
    camera.SetParallelScale(0.5 * SIZE[1] / SIZE[0] * 1.35 * length)
    renderer.ResetCameraClippingRange()
    window.Render()

    write_png(window, "rubber_band.png")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: rubber_band.py RUN_DIRECTORY")
    main(sys.argv[1])
