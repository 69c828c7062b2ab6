"""Views of a results folder in ParaView, after the figures of D. Durville's paper on woven fabrics.

    pvbatch data/paraview/trame_views.py results/plain pictures    a PNG file of each view, into the folder pictures
    TRAME_RESULTS=results/plain paraview --script=data/paraview/trame_views.py

In ParaView's Python shell (View > Python Shell):

    import sys; sys.path.append("data/paraview"); import trame_views
    trame_views.show("results/plain")

The folder holds vtk/fibers.pvd and vtk/yarns.pvd as run_workflow writes them. Where strain_post has written
strains/yarns.pvd beside states.h5, the views of tension show that pair of states, else all of the run.

fibers            fibers as tubes, warp blue, weft orange
fibers_cut        the same, cut open along a warp yarn
horizontal        horizontal strain of the yarns
horizontal_cut    the same, vertical strain, greatest shear and axial strain on a cut across the warp yarns,
vertical_cut      under the outlines of the fibers
shear_cut
axial_cut
"""

import os
import sys

import numpy
from paraview import simple as pv
from paraview import servermanager
from vtk.util.numpy_support import vtk_to_numpy

WARP, WEFT = 0, 1  # values of the array family
FAMILY_COLOURS = {"0": (0.16, 0.42, 0.70), "1": (0.92, 0.56, 0.18), "2": (0.30, 0.60, 0.44)}
SIZE = (1600, 900)
# From the patch to the camera.
AWAY = {"perspective": (-0.45, -0.9, 0.85), "along -x": (1, 0, 0), "along +y": (0, -1, 0)}


def opened(file):
    """A time series, at its last time."""
    if not os.path.isfile(file):
        raise SystemExit(f"trame_views: {file}: is not there; must be a results folder of run_workflow")
    reader = pv.PVDReader(FileName=file)
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues) or [0.0]
    pv.GetAnimationScene().AnimationTime = times[-1]
    pv.UpdatePipeline(time=times[-1], proxy=reader)
    return reader


def of_cells(source, array, lowest, highest):
    """The cells whose value of the array is in that range, as a source."""
    part = pv.Threshold(Input=source, Scalars=["CELLS", array])
    part.ThresholdMethod, part.LowerThreshold, part.UpperThreshold = "Between", lowest, highest
    part.UpdatePipeline()
    return part


def middle_yarn(fibers, family):
    """Bounds (x0, x1, y0, y1, z0, z1) of the middle yarn of a family; of everything where there is none."""
    of_family = of_cells(fibers, "family", family, family)
    if of_family.GetDataInformation().GetNumberOfCells() == 0:
        return fibers.GetDataInformation().GetBounds()
    first, last = (int(k) for k in of_family.CellData["yarn"].GetRange())
    yarn = (first + last + 1) // 2
    return of_cells(of_family, "yarn", yarn, yarn).GetDataInformation().GetBounds()


def middle(bounds):
    return [0.5 * (bounds[2 * i] + bounds[2 * i + 1]) for i in range(3)]


def tubes(fibers):
    """Fibers in their true thickness."""
    surface = pv.ExtractSurface(Input=fibers)
    tube = pv.Tube(Input=surface, Scalars=["POINTS", "radius"], VaryRadius="By Absolute Scalar", NumberofSides=16,
                   Capping=1)
    tube.UpdatePipeline()
    return tube


def cut(source, origin, normal):
    section = pv.Slice(Input=source, SliceType="Plane", Triangulatetheslice=0)
    section.SliceType.Origin, section.SliceType.Normal = origin, normal
    section.UpdatePipeline()
    return section


def new_view(name, away):
    """An empty white view in a layout of its own, seen from that direction, z up."""
    view = pv.CreateRenderView()
    view.ViewSize = SIZE
    view.UseColorPaletteForBackground = 0
    view.BackgroundColorMode = "Single Color"
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 0
    view.CameraParallelProjection = int(away != "perspective")
    pv.AssignViewToLayout(view=view, layout=pv.CreateLayout(name=name))
    return view


def look(view, source, away):
    """Puts the camera where the source just fills the view."""
    bounds = numpy.array(source.GetDataInformation().GetBounds()).reshape(3, 2)
    centre, size = bounds.mean(axis=1), numpy.linalg.norm(bounds[:, 1] - bounds[:, 0])
    backward = numpy.array(AWAY[away]) / numpy.linalg.norm(AWAY[away])
    right = numpy.cross([0, 0, 1], backward)
    right /= numpy.linalg.norm(right)
    corners = numpy.array([[x, y, z] for x in bounds[0] for y in bounds[1] for z in bounds[2]]) - centre
    half_width, half_height = (numpy.abs(corners @ axis).max() for axis in (right, numpy.cross(backward, right)))
    scale = max(1.1 * half_height, 1.25 * half_width * SIZE[1] / SIZE[0])  # room for the colour bar at the side
    view.CameraFocalPoint = list(centre)
    view.CameraPosition = list(centre + 4 * size * backward)
    view.CameraViewUp = [0, 0, 1]
    view.CameraParallelScale = scale
    view.CameraViewAngle = 2 * numpy.degrees(numpy.arctan(scale / (4 * size)))


def show_families(source, view):
    """Warp blue, weft orange."""
    display = pv.Show(source, view)
    pv.ColorBy(display, ("CELLS", "family"))
    colours = pv.GetColorTransferFunction("family")
    colours.InterpretValuesAsCategories = 1
    colours.Annotations = [text for pair in (("0", "warp"), ("1", "weft"), ("2", "other")) for text in pair]
    colours.IndexedColors = [c for key in sorted(FAMILY_COLOURS) for c in FAMILY_COLOURS[key]]
    display.SetScalarBarVisibility(view, False)
    display.Specular = 0.15
    return display


def largest(source, array):
    """The size that 98 % of the cells stay below."""
    data = servermanager.Fetch(source)
    is_composite = data.IsA("vtkMultiBlockDataSet")
    blocks = [data.GetBlock(b) for b in range(data.GetNumberOfBlocks())] if is_composite else [data]
    arrays = [block.GetCellData().GetArray(array) for block in blocks if block is not None]
    values = numpy.abs(numpy.concatenate([vtk_to_numpy(a) for a in arrays if a is not None] or [numpy.zeros(1)]))
    values = values[numpy.isfinite(values)]
    return float(numpy.quantile(values, 0.98)) if values.size else 0.0


def show_strain(source, view, array):
    """Colours of a strain: blue to red about zero, or where it has no sign from zero on."""
    display = pv.Show(source, view)
    pv.ColorBy(display, ("CELLS", array))
    colours = pv.GetColorTransferFunction(array)
    limit = largest(source, array) or 1e-12
    has_sign = array != "gamma_max"
    colours.ApplyPreset("Cool to Warm" if has_sign else "Viridis (matplotlib)", True)
    colours.RescaleTransferFunction(-limit if has_sign else 0.0, limit)
    colours.NanColor = [1, 1, 1]
    bar = pv.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = array, ""
    bar.RangeLabelFormat, bar.AutomaticLabelFormat, bar.LabelFormat = "%.2g", 0, "%.2g"
    bar.TitleColor = bar.LabelColor = [0.1, 0.1, 0.1]
    display.SetScalarBarVisibility(view, True)
    return display


def show_outlines(section, view):
    display = pv.Show(section, view)
    display.ColorArrayName = ["POINTS", ""]  # none
    display.SetRepresentationType("Surface")
    display.AmbientColor = display.DiffuseColor = [0.1, 0.1, 0.1]
    display.LineWidth = 1.5


def view_fibers(fibers, _yarns, _tension):
    view, tube = new_view("fibers", "perspective"), tubes(fibers)
    show_families(tube, view)
    look(view, tube, "perspective")
    return view


def view_fibers_cut(fibers, _yarns, _tension):
    view, tube = new_view("fibers_cut", "along +y"), tubes(fibers)
    origin = middle(middle_yarn(fibers, WARP))
    clip = pv.Clip(Input=tube, ClipType="Plane", Invert=0)
    clip.ClipType.Origin, clip.ClipType.Normal = origin, [0, 1, 0]
    clip.UpdatePipeline()
    show_families(clip, view).BackfaceRepresentation = "Cull Backface"
    # Tubes are hollow: their insides, without light and shade, look like the sections of the fibers.
    inside = show_families(pv.ExtractSurface(Input=clip), view)
    inside.BackfaceRepresentation = "Cull Frontface"
    inside.Ambient, inside.Diffuse, inside.Specular = 1.0, 0.0, 0.0
    show_outlines(cut(tube, origin, [0, 1, 0]), view)
    look(view, clip, "along +y")
    return view


def view_horizontal(_fibers, yarns, _tension):
    view = new_view("horizontal", "perspective")
    show_strain(yarns, view, "E_horizontal")
    look(view, yarns, "perspective")
    return view


def cut_view(name, array, of_tension):
    """A function that shows a strain on a cut across the warp yarns, where they cross the middle weft yarn."""
    def view_cut(fibers, yarns, tension):
        view = new_view(name, "along -x")
        origin = middle(middle_yarn(fibers, WEFT))
        warp = of_cells(tension if of_tension else yarns, "family", WARP, WARP)
        section = cut(warp, origin, [1, 0, 0])
        flat = show_strain(section, view, array)
        flat.Ambient, flat.Diffuse = 1.0, 0.0  # the colours of the scale, unshaded
        show_outlines(cut(tubes(of_cells(fibers, "family", WARP, WARP)), origin, [1, 0, 0]), view)
        look(view, section, "along -x")
        return view
    return view_cut


VIEWS = {
    "fibers": view_fibers,
    "fibers_cut": view_fibers_cut,
    "horizontal": view_horizontal,
    "horizontal_cut": cut_view("horizontal_cut", "E_horizontal", False),
    "vertical_cut": cut_view("vertical_cut", "E_vertical", False),
    "shear_cut": cut_view("shear_cut", "gamma_max", True),
    "axial_cut": cut_view("axial_cut", "E_axial", True),
}


def show(folder):
    """Makes all views of a results folder and returns them by name."""
    fibers = opened(os.path.join(folder, "vtk", "fibers.pvd"))
    yarns = opened(os.path.join(folder, "vtk", "yarns.pvd"))
    pair = os.path.join(folder, "strains", "yarns.pvd")
    tension = opened(pair) if os.path.isfile(pair) else yarns
    return {name: make(fibers, yarns, tension) for name, make in VIEWS.items()}


def save(folder, pictures):
    """Writes a PNG file of each view."""
    os.makedirs(pictures, exist_ok=True)
    for name, view in show(folder).items():
        pv.SaveScreenshot(os.path.join(pictures, name + ".png"), view, ImageResolution=SIZE)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        save(sys.argv[1], sys.argv[2])
    elif "TRAME_RESULTS" in os.environ:
        show(os.environ["TRAME_RESULTS"])
    else:
        raise SystemExit("trame_views: give a results folder and one for the pictures, or set TRAME_RESULTS")
