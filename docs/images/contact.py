#!/usr/bin/python3
"""Makes ball_drop.png, gripper.png, gripped_ball.png, pressed_column.png, colliding_blocks.png or block_pile.png of the gallery:
/usr/bin/python3 docs/images/contact.py RUN_DIRECTORY [NAME]

The directory is that of a run of the scene with this name. The body is drawn at
several times side by side, with the planes of the scene where they are then.
"""

import json
import os
import sys

import numpy as np
import vtk

from picture import write_png
from rubber_band import deformed, frames, label
from spring import colour_bar, surface

PICTURES = {
    "ball_drop": {"times": [0.0, 0.2, 0.26, 0.28, 0.3, 0.34, 0.52], "distance": 0.26, "top": 1.5e4, "size": (1000, 330),
                  "half": (0.13, 0.12), "zoom": 1.75, "eye": (0.0, 0.3, 1.0)},
    "gripper": {"times": [0.0, 0.3, 0.5, 1.5], "distance": 0.19, "top": 1.5e4, "size": (1000, 420), "half": (0.06, 0.06),
                "zoom": 1.8, "eye": (0.3, 0.3, 1.0)},
    "gripped_ball": {"times": [0.0, 0.3, 0.6, 1.3], "distance": 0.36, "top": 4.0e4, "size": (1000, 420), "half": (0.1, 0.1),
                     "zoom": 1.7, "eye": (0.3, 0.3, 1.0)},
    "pressed_column": {"times": [0.0, 0.5, 1.5], "distance": 0.2, "top": 5.0e5, "size": (1000, 420), "half": (0.075, 0.075),
                       "zoom": 1.8, "eye": (0.3, 0.3, 1.0)},
    "colliding_blocks": {"times": [0.0, 0.08, 0.104, 0.128, 0.2], "distance": 0.95, "top": 8.0e3, "size": (1000, 300),
                         "zoom": 2.3, "eye": (0.1, 0.35, 1.0)},
    "block_pile": {"times": [0.0, 0.2, 0.4, 1.0], "distance": 0.75, "top": 4.0e3, "size": (1000, 420),
                   "zoom": 1.6, "eye": (0.2, 0.35, 1.0)},
}  # fmt: skip


def path_at(scene, obstacle, time):
    """∫ a dt from 0 to the time, with the amplitude a of the obstacle's velocity."""
    name = obstacle.get("amplitude")
    if not name:
        return time
    points = next(a for a in scene["amplitude"] if a["name"] == name)["points"]
    times = np.linspace(0.0, time, 2001)
    factors = np.interp(times, *np.transpose(points))
    return float(np.sum(0.5 * (factors[1:] + factors[:-1]) * np.diff(times)))


def plate(scene, obstacle, time, half, middle):
    """A square on the plane, about the middle of the body where it is across the plane's normal."""
    normal = np.array(obstacle["normal"])
    point = np.array(obstacle["point"]) + path_at(scene, obstacle, time) * np.array(obstacle.get("velocity", [0, 0, 0]))
    across = np.eye(3)[[axis for axis in range(3) if abs(normal[axis]) < 0.5]]
    # A moving plate shows its motion in its own plane, one at rest is drawn below the body.
    reference = point if obstacle.get("velocity") else middle
    center = middle + normal * np.dot(point - middle, normal)
    for axis in across:
        shift = np.dot(reference - center, axis)
        if obstacle.get("velocity") and np.dot(obstacle["velocity"], axis) != 0.0:
            center = center + (shift + half[0] * 0.83) * axis
    source = vtk.vtkPlaneSource()
    source.SetOrigin(center - half[0] * across[0] - half[1] * across[1])
    source.SetPoint1(center + half[0] * across[0] - half[1] * across[1])
    source.SetPoint2(center - half[0] * across[0] + half[1] * across[1])
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(0.55, 0.6, 0.65)
    actor.GetProperty().SetOpacity(0.3)
    return actor


def main(directory, name=None):
    with open(os.path.join(directory, "summary.json"), encoding="utf-8") as file:
        scene = json.load(file)["scene"]
    names = {"floor": "ball_drop", "left": "gripper", "table": "pressed_column"}
    name = name or names[scene["obstacle"][0]["name"]]
    picture = PICTURES[name]
    colours = vtk.vtkColorTransferFunction()  # cool to warm
    colours.SetColorSpaceToDiverging()
    colours.AddRGBPoint(0.0, 0.23, 0.30, 0.75)
    colours.AddRGBPoint(picture["top"], 0.71, 0.02, 0.15)
    right = np.cross([0.0, 1.0, 0.0], picture["eye"])
    right /= np.linalg.norm(right)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    found = frames(directory)
    for column, wanted in enumerate(picture["times"]):
        time, path = min(found, key=lambda frame: abs(frame[0] - wanted))
        warp = deformed(path)
        bounds = np.array(warp.GetOutput().GetBounds()).reshape(3, 2)
        middle = bounds.mean(axis=1)
        mapper, actor = surface(warp, edges=True)
        mapper.SetScalarModeToUseCellFieldData()
        mapper.SelectColorArray("von_mises")
        mapper.SetLookupTable(colours)
        # Side by side as the eye sees it.
        place = picture["distance"] * column * right - np.array([middle[0], 0.0, 0.0])
        planes = [o for o in scene.get("obstacle", []) if o["kind"] == "plane"]
        actors = [actor] + [plate(scene, o, time, picture["half"], middle) for o in planes]
        for each in actors:
            each.SetPosition(*place)
            renderer.AddActor(each)
        top = max(actor.GetBounds()[3] for actor in actors)
        renderer.AddActor(label(f"{time:.2f} s", (place[0] + middle[0] - 0.03, top + 0.02, place[2] + middle[2])))
    for actor in colour_bar(colours):
        renderer.AddActor2D(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetAlphaBitPlanes(True)
    window.SetSize(*picture["size"])
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetPosition(*picture["eye"])
    camera.SetFocalPoint(0, 0, 0)
    renderer.ResetCamera()
    camera.Zoom(picture["zoom"])
    camera.SetWindowCenter(0.16, 0.0)  # the bar of colours is on the right
    window.Render()
    write_png(window, name + ".png")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: contact.py RUN_DIRECTORY [NAME]")
    main(*sys.argv[1:])
