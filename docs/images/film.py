#!/usr/bin/python3
"""Makes a short film of a run: /usr/bin/python3 docs/images/film.py RUN_DIRECTORY NAME [OPTION...]

The frames of the run are drawn deformed and coloured by von Mises stress, and written as an animated picture,
NAME.webp, beside this script. The folder's README says how the films of the gallery are made.
"""

import argparse
import os
import xml.etree.ElementTree

import numpy as np
import vtk
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy

HERE = os.path.dirname(os.path.abspath(__file__))


def frames_of(directory, most):
    """Times and paths of the frames, of which at most that many are taken, evenly; of the body, and of the
    obstacles (None without them)."""
    tree = xml.etree.ElementTree.parse(os.path.join(directory, "frames.pvd"))
    frames = {}
    for entry in tree.iter("DataSet"):
        path = os.path.join(directory, entry.get("file"))
        paths = frames.setdefault(float(entry.get("timestep")), [None, None])
        paths[os.path.basename(path).startswith("obstacles")] = path
    frames = [(time, *paths) for time, paths in frames.items()]
    places = np.unique(np.linspace(0, len(frames) - 1, min(most, len(frames))).round().astype(int))
    return [frames[i] for i in places]


def read(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    displacement = grid.GetPointData().GetArray("displacement")
    points = vtk_to_numpy(grid.GetPoints().GetData()) + vtk_to_numpy(displacement)
    deformed = vtk.vtkUnstructuredGrid()
    deformed.DeepCopy(grid)
    moved = vtk.vtkPoints()
    moved.SetDataTypeToDouble()
    moved.SetNumberOfPoints(len(points))
    vtk_to_numpy(moved.GetData())[:] = points
    deformed.SetPoints(moved)
    return deformed


def image_of(window):
    grabbed = vtk.vtkWindowToImageFilter()
    grabbed.SetInput(window)
    grabbed.ReadFrontBufferOff()
    grabbed.Update()
    data = grabbed.GetOutput()
    width, height, _ = data.GetDimensions()
    pixels = vtk_to_numpy(data.GetPointData().GetScalars()).reshape(height, width, 3)
    return Image.fromarray(pixels[::-1].copy())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("directory", help="of a run with frames")
    parser.add_argument("name", help="of the film, without its ending")
    parser.add_argument("--view", default="0.35,0.25,1", help="direction towards the eye")
    parser.add_argument("--up", default="0,1,0", help="direction that is upwards in the picture")
    parser.add_argument("--range", type=float, help="stress at the end of the colours, Pa; by default the 98th percentile")
    parser.add_argument("--seconds", type=float, default=4.0, help="duration of the film")
    parser.add_argument("--most", type=int, default=60, help="most pictures")
    parser.add_argument("--size", default="480,360")
    parser.add_argument("--obstacles", action="store_true", help="show the obstacles, and let the picture contain them")
    parser.add_argument("--edges", action="store_true", help="draw the edges of the mesh")
    parser.add_argument("--zoom", type=float, default=1.0)
    arguments = parser.parse_args()
    numbers = lambda text: [float(part) for part in text.split(",")]

    frames = frames_of(arguments.directory, arguments.most)
    grids = [(time, read(path)) for time, path, _ in frames]
    obstacles = [read(path) if path and arguments.obstacles else None for _, _, path in frames]
    stresses = [vtk_to_numpy(grid.GetCellData().GetArray("von_mises")) for _, grid in grids]
    top = arguments.range or float(np.percentile(np.concatenate(stresses), 98))

    colours = vtk.vtkColorTransferFunction()  # cool to warm
    colours.SetColorSpaceToDiverging()
    colours.AddRGBPoint(0.0, 0.23, 0.30, 0.75)
    colours.AddRGBPoint(top, 0.71, 0.02, 0.15)
    smooth = vtk.vtkCellDataToPointData()
    surface = vtk.vtkDataSetSurfaceFilter()
    surface.SetInputConnection(smooth.GetOutputPort())
    surface.SetNonlinearSubdivisionLevel(2)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(surface.GetOutputPort())
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("von_mises")
    mapper.SetLookupTable(colours)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetAmbient(0.3)
    actor.GetProperty().SetEdgeVisibility(arguments.edges)
    actor.GetProperty().SetLineWidth(0.5)
    label = vtk.vtkTextActor()
    label.SetPosition(10, 8)
    label.GetTextProperty().SetColor(0, 0, 0)
    label.GetTextProperty().SetFontSize(15)

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0.94, 0.94, 0.94)
    renderer.AddActor(actor)
    renderer.AddActor2D(label)
    rigid = vtk.vtkDataSetMapper()
    rigid.ScalarVisibilityOff()
    if arguments.obstacles:
        around = vtk.vtkActor()
        around.SetMapper(rigid)
        around.GetProperty().SetColor(0.62, 0.66, 0.7)
        around.GetProperty().SetAmbient(0.5)
        around.GetProperty().SetLineWidth(0.5)
        renderer.AddActor(around)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetSize(*[int(part) for part in numbers(arguments.size)])
    window.AddRenderer(renderer)
    # The camera shows all that the body ever reaches.
    bounds = np.array([grid.GetBounds() for grid in [grid for _, grid in grids] + [o for o in obstacles if o]])
    box = [f(bounds[:, i]) for i, f in enumerate((min, max) * 3)]
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(0, 0, 0)
    camera.SetPosition(*numbers(arguments.view))
    camera.SetViewUp(*numbers(arguments.up))
    renderer.ResetCamera(box)
    camera.Zoom(arguments.zoom)

    last = grids[-1][0]
    unit, factor = ("ms", 1e3) if last < 0.1 else ("s", 1.0)
    images = []
    for (time, grid), obstacle in zip(grids, obstacles):
        smooth.SetInputData(grid)
        if obstacle:
            rigid.SetInputData(obstacle)
        label.SetInput(f"{factor * time:.2f} {unit}     von Mises stress 0 to {top:.2g} Pa")
        renderer.ResetCameraClippingRange(box)
        window.Render()
        images.append(image_of(window))
    images[0].save(os.path.join(HERE, arguments.name + ".webp"), save_all=True,
                   append_images=images[1:], duration=int(1000 * arguments.seconds / len(images)),
                   loop=0, quality=55, method=6)  # fmt: skip


if __name__ == "__main__":
    main()
