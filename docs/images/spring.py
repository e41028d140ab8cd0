#!/usr/bin/python3
"""Makes spring.png of the README: /usr/bin/python3 docs/images/spring.py RUN_DIRECTORY

The directory is that of a run of examples/scenes/serpentine_spring.toml, such as midpoint-0.00024 of
the study that scripts/demo makes. The last frame is drawn deformed, the body at rest behind it.
"""

import os
import sys

import vtk

from picture import write_png

SIZE = (1000, 860)
TOP_OF_RANGE = 1.8e5  # Pa


def surface(source, edges):
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetEdgeVisibility(edges)
    actor.GetProperty().SetEdgeColor(0.25, 0.25, 0.25)
    actor.GetProperty().SetAmbient(0.25)
    return mapper, actor


def colour_bar(table):
    """The bar. Its title is a text of its own above it: as part of the bar it would run into the
    topmost number."""
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetNumberOfLabels(4)
    bar.SetLabelFormat("%.0f")
    bar.UnconstrainedFontSizeOn()
    bar.SetPosition(0.84, 0.27)
    bar.SetWidth(0.11)
    bar.SetHeight(0.46)
    title = vtk.vtkTextActor()
    title.SetInput("von Mises stress [Pa]")
    title.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    title.SetPosition(0.80, 0.76)
    for text in (bar.GetLabelTextProperty(), title.GetTextProperty()):
        text.SetFontFamilyToArial()
        text.SetFontSize(15)
        text.SetColor(0, 0, 0)
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    return bar, title


def main(directory):
    frames = sorted(f for f in os.listdir(os.path.join(directory, "frames")) if f.endswith(".vtu"))
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(directory, "frames", frames[-1]))
    reader.Update()
    warp = vtk.vtkWarpVector()
    warp.SetInputConnection(reader.GetOutputPort())
    warp.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "displacement")

    colours = vtk.vtkColorTransferFunction()  # cool to warm
    colours.SetColorSpaceToDiverging()
    colours.AddRGBPoint(0.0, 0.23, 0.30, 0.75)
    colours.AddRGBPoint(TOP_OF_RANGE, 0.71, 0.02, 0.15)
    mapper, deformed = surface(warp, edges=True)
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectColorArray("von_mises")
    mapper.SetLookupTable(colours)
    rest_mapper, rest = surface(reader, edges=False)
    rest_mapper.ScalarVisibilityOff()
    rest.GetProperty().SetColor(0.6, 0.6, 0.6)
    rest.GetProperty().SetOpacity(0.35)

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for actor in (deformed, rest):
        renderer.AddActor(actor)
    for actor in colour_bar(colours):
        renderer.AddActor2D(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetSize(*SIZE)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(0.35, 0.25, 1.0)
    camera.SetFocalPoint(0, 0, 0)
    renderer.ResetCamera()
    camera.Zoom(1.2)
    window.Render()

    write_png(window, "spring.png")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: spring.py RUN_DIRECTORY")
    main(sys.argv[1])
