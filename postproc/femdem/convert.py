"""Meshes of other programs to meshes of this one; results to other formats.

    femdem-convert plate.inp plate.msh --scale 0.001 --fracture JOINT
    femdem-convert RESULTS --vtu                     # RESULTS/vtu/: a file a time, and fields.pvd for ParaView
    femdem-convert RESULTS --xdmf                    # RESULTS/xdmf/: XDMF 3.0, one part a file, which meshio reads too
    femdem-convert RESULTS --gis edges.gpkg --crs EPSG:2056

A mesh is read by meshio (Abaqus, VTK, VTU, XDMF, gmsh and others). Sets of elements become physical surfaces and curves, sets of
nodes curves along the outer boundary, physical points elsewhere. What has no sets may have an array of whole numbers (--groups).
"""

import argparse
import sys
import warnings
from pathlib import Path

from femdem import exports, meshes
from femdem.results import Results, ResultsError

BAD_INPUT = 2


def arguments_of(words=None):
    """The command line"""
    parser = argparse.ArgumentParser(
        prog="femdem-convert", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("input", type=Path, help="mesh file, or results directory")
    parser.add_argument(
        "output", type=Path, nargs="?", help="mesh file to write (default: the input's name with .msh)"
    )
    mesh = parser.add_argument_group("meshes")
    mesh.add_argument(
        "--scale", type=float, default=1.0, help="metres in a unit of the file (0.001: it is in mm)"
    )
    mesh.add_argument(
        "--plane", choices=meshes.PLANES, default="xy", help="plane the mesh lies in (default xy)"
    )
    mesh.add_argument(
        "--surfaces", nargs="+", default=[], help="sets of elements that become materials (default: all)"
    )
    mesh.add_argument(
        "--fracture",
        action="append",
        default=[],
        metavar="SET",
        help="set of nodes whose inner edges are a fracture (repeat)",
    )
    mesh.add_argument(
        "--groups", metavar="ARRAY", help="array of whole numbers on the elements that tells the groups"
    )
    results = parser.add_argument_group("results")
    results.add_argument("--vtu", action="store_true", help="write VTU files and fields.pvd")
    results.add_argument("--xdmf", action="store_true", help="write XDMF 3.0 files that point into fields.h5")
    results.add_argument(
        "--gis", type=Path, metavar="FILE", help="write the block edges: .gpkg, .geojson or .shp"
    )
    results.add_argument("--crs", help="coordinate system of the mesh, for --gis, such as EPSG:2056")
    results.add_argument("--out", type=Path, help="directory for --vtu and --xdmf (default: in the results)")
    return parser.parse_args(words)


def convert_mesh(arguments):
    """A mesh file to a gmsh file"""
    output = arguments.output or Path(arguments.input.name).with_suffix(".msh")
    if output.suffix != ".msh":
        raise ResultsError(f"{output}: a mesh of the program ends in .msh")
    if output.exists() and output.samefile(arguments.input):
        raise ResultsError(f"{output} is the input itself; name another file to write")
    if not arguments.scale > 0.0:
        raise ResultsError(f"--scale {arguments.scale:g}: it must be positive")
    try:
        made = meshes.to_plane(
            meshes.read(arguments.input),
            arguments.plane,
            arguments.scale,
            arguments.surfaces,
            arguments.fracture,
            arguments.groups,
        )
    except ResultsError as error:
        name = str(arguments.input)
        texts = str(error).splitlines()
        raise ResultsError(
            "\n".join(text if text.startswith(name) else f"{name}: {text}" for text in texts)
        ) from error
    meshes.write(made, output)
    print(meshes.summary(made, output))


def convert_results(arguments):
    """A results directory to what is asked for"""
    run = Results(arguments.input)
    if not (arguments.vtu or arguments.xdmf or arguments.gis):
        raise ResultsError(
            f"{arguments.input} is a directory: say what its results become: --vtu, --xdmf or --gis FILE"
        )
    if arguments.vtu:
        print(exports.write_vtu(run.fields, arguments.out or arguments.input / "vtu"))
    if arguments.xdmf:
        for path in exports.write_xdmf(run.fields, arguments.out or arguments.input / "xdmf"):
            print(path)
    if arguments.gis:
        with warnings.catch_warnings():
            # Meshes in coordinates of their own have no coordinate system
            warnings.filterwarnings("ignore", message="'crs' was not provided")
            run.edges.to_geopandas(arguments.crs).reset_index().to_file(arguments.gis)
        print(arguments.gis)


def main(words=None):
    arguments = arguments_of(words)
    try:
        if arguments.input.is_dir():
            convert_results(arguments)
        else:
            convert_mesh(arguments)
    except (ResultsError, OSError) as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        sys.exit(BAD_INPUT)
