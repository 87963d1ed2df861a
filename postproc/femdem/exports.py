"""Results as objects and files of other libraries: pandas, geopandas, pyvista, VTU and XDMF files.

Each library is imported when it is asked for; the message of one that is missing names the extra that brings it.
"""

import importlib
import os
from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np

from femdem.results import ResultsError

EXTRA = {
    "pandas": "gis",
    "geopandas": "gis",
    "shapely": "gis",
    "pyvista": "vtk",
    "meshio": "vtk",
}
# The two kinds of cells of a snapshot: places of their fields, cells in meshio's, XDMF's words, dataset of the cells
PARTS = {
    "rock": ("triangles", "triangle", "Triangle", "triangles"),
    "joints": ("joints", "line", "Polyline", "joint_lines"),
}


def library(name):
    """A library that need not be there"""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ResultsError(
            f"Python has no module {name} ({error}); it comes with the extra {EXTRA[name]!r}: "
            f"pip install './postproc[{EXTRA[name]}]' (manual/python.md)"
        ) from error


# ---- Tables -------------------------------------------------------------------------------------------------------


def history_frame(history):
    """The history as a pandas.DataFrame, a column a name"""
    return library("pandas").DataFrame({name: history[name] for name in history.columns})


def edges_frame(edges):
    """The block edges as a pandas.DataFrame, a row a block edge, its number as the index"""
    return library("pandas").DataFrame(edges.columns()).set_index("id")


def edges_geoframe(edges, crs=None):
    """The block edges with their lines as a geopandas.GeoDataFrame; crs: coordinate system of the mesh, such as 'EPSG:2056'"""
    geopandas, shapely = library("geopandas"), library("shapely")
    mesh = edges.mesh()
    table = edges_frame(edges)
    lines = [mesh.joint_lines[mesh.block_edge == number] for number in table.index]
    geometry = [shapely.line_merge(shapely.MultiLineString(list(ends))) for ends in lines]
    return geopandas.GeoDataFrame(table, geometry=geometry, crs=crs)


# ---- Meshes with fields -------------------------------------------------------------------------------------------


def part_data(fields, part, step=-1):
    """Points (n, 3), cells, fields on points and on cells of the rock or of the joints of a snapshot"""
    mesh, place = fields.mesh(step), PARTS[part][0]
    points = np.column_stack([mesh.coordinates, np.zeros(len(mesh.coordinates))])
    cells = mesh.triangles if part == "rock" else mesh.joints[:, :2]
    on_points, on_cells = {}, {}
    for name, (where, _, _) in fields.names(step).items():
        values = fields.read(name, step)
        if values.ndim == 2:
            values = np.column_stack([values, np.zeros(len(values))])
        if where == "nodes":
            on_points[name] = values
        elif where == place:
            on_cells[name] = values
    on_cells["group"] = mesh.triangle_group if part == "rock" else mesh.joint_group
    if part == "joints":
        on_cells["block_edge"] = mesh.block_edge
    return points, cells, on_points, on_cells


def parts(fields, step=-1):
    """Names of the parts a snapshot has"""
    return ["rock", "joints"] if len(fields.mesh(step).joints) else ["rock"]


def multiblock(fields, step=-1):
    """A snapshot as a pyvista.MultiBlock with the blocks 'rock' and 'joints'"""
    pyvista = library("pyvista")
    blocks = pyvista.MultiBlock()
    for part in parts(fields, step):
        points, cells, on_points, on_cells = part_data(fields, part, step)
        kind = pyvista.CellType.TRIANGLE if part == "rock" else pyvista.CellType.LINE
        grid = pyvista.UnstructuredGrid({kind: cells}, points)
        grid.point_data.update(on_points)
        grid.cell_data.update(on_cells)
        blocks[part] = grid
    return blocks


def write_vtu(fields, folder):
    """Every snapshot as VTU files, and fields.pvd that names them with their times; its path"""
    meshio = library("meshio")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    for step, (name, time) in enumerate(zip(fields.steps, fields.times, strict=True)):
        for number, part in enumerate(parts(fields, step)):
            points, cells, on_points, on_cells = part_data(fields, part, step)
            path = folder / f"{part}_{name.removeprefix('step_')}.vtu"
            meshio.Mesh(
                points,
                [(PARTS[part][1], cells)],
                point_data=on_points,
                cell_data={key: [values] for key, values in on_cells.items()},
            ).write(path)
            ElementTree.SubElement(
                collection, "DataSet", timestep=repr(float(time)), part=str(number), name=part, file=path.name
            )
    ElementTree.indent(root)
    index = folder / "fields.pvd"
    ElementTree.ElementTree(root).write(index, encoding="utf-8", xml_declaration=True)
    return index


def write_xdmf(fields, folder):
    """XDMF 3.0 files that meshio's time series reads too: one for each part and mesh, which point into fields.h5; their paths

    A file holds one part on one mesh, since a time series has one mesh for all times; cracks begin a new one.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    data_file = os.path.relpath(fields.path.resolve(), folder.resolve())
    meshes = {}
    for step in range(len(fields.steps)):
        meshes.setdefault(fields.mesh_name(step), []).append(step)
    written = []
    for number, (mesh, steps) in enumerate(meshes.items(), start=1):
        for part in parts(fields, steps[0]):
            suffix = f"_mesh_{number}" if len(meshes) > 1 else ""
            path = folder / f"{part}{suffix}.xdmf"
            lines = ['<?xml version="1.0"?>', '<Xdmf Version="3.0">', "<Domain>"]
            lines.append(f'<Grid Name="{part}" GridType="Collection" CollectionType="Temporal">')
            for step in steps:
                lines += xdmf_grid(fields, part, mesh, step, data_file)
            path.write_text("\n".join([*lines, "</Grid>", "</Domain>", "</Xdmf>", ""]), encoding="utf-8")
            written.append(path)
    return written


def xdmf_grid(fields, part, mesh, step, data_file):
    """Lines of the XDMF grid of one time"""
    place, _, shape, cells = PARTS[part]
    group = fields.steps[step]
    with fields.open() as file:

        def item(dataset):
            array = file[dataset]
            number = "Int" if array.dtype.kind == "i" else "Float"
            size = " ".join(str(n) for n in array.shape)
            return (
                f'<DataItem Format="HDF" NumberType="{number}" Precision="{array.dtype.itemsize}" '
                f'Dimensions="{size}">{data_file}:/{dataset}</DataItem>'
            )

        lines = [
            f'<Grid Name="{group}" GridType="Uniform">',
            f'<Time Value="{float(fields.times[step])!r}"/>',
            f'<Topology TopologyType="{shape}" NodesPerElement="{file[mesh][cells].shape[1]}" '
            f'NumberOfElements="{len(file[mesh][cells])}">{item(f"{mesh}/{cells}")}</Topology>',
            f'<Geometry GeometryType="XY">{item(f"{mesh}/coordinates")}</Geometry>',
        ]
        for name, (where, _, _) in fields.names(step).items():
            if where not in ("nodes", place):
                continue
            home = group if name in file[group] else mesh
            kind = "Vector" if file[home][name].ndim == 2 else "Scalar"
            lines.append(
                f'<Attribute Name={quoteattr(name)} AttributeType="{kind}" Center="{"Node" if where == "nodes" else "Cell"}">'
                f"{item(f'{home}/{name}')}</Attribute>"
            )
    return [*lines, "</Grid>"]
