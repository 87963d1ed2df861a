"""Wrong meshes, made from a good one, each with words that the program's messages must hold.

The good mesh is three by three unit squares of four triangles each; a fracture crosses the middle row from (1, 1) to
(2, 1), and a group 'bottom' lies along y = 0.

Run as a program it writes all of them:  python3 wrong_meshes.py DIRECTORY
"""

import sys
from pathlib import Path

SQUARES = 3
LINE, TRIANGLE, QUADRANGLE = 1, 2, 3
NODES_OF = {LINE: 2, TRIANGLE: 3, QUADRANGLE: 4}
GROUPS = {"bottom": (1, 1), "fracture": (1, 2), "rock": (2, 3)}


class Mesh:
    """Nodes, elements (gmsh type, group number, node numbers) and named groups of a gmsh file of format 2.2."""

    def __init__(self):
        self.version = "2.2"
        self.groups = dict(GROUPS)
        corners = [(float(x), float(y)) for y in range(SQUARES + 1) for x in range(SQUARES + 1)]
        centres = [(x + 0.5, y + 0.5) for y in range(SQUARES) for x in range(SQUARES)]
        self.nodes = corners + centres
        self.elements = [(LINE, 1, (x + 1, x + 2)) for x in range(SQUARES)]
        self.elements.append((LINE, 2, (self.at(1, 1), self.at(2, 1))))
        for x, y in centres:
            around = [self.at(x + i, y + j) for i, j in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
            for k in range(4):
                self.elements.append((TRIANGLE, 3, (around[k], around[(k + 1) % 4], self.at(x, y))))

    def at(self, x, y):
        """Number of the node at a place."""
        return self.nodes.index((x, y)) + 1

    def move(self, place, to):
        self.nodes[self.at(*place) - 1] = to

    def add_node(self, x, y):
        self.nodes.append((x, y))
        return len(self.nodes)

    def add(self, kind, group, *nodes):
        self.elements.append((kind, group, nodes))

    def without(self, kind):
        self.elements = [element for element in self.elements if element[0] != kind]

    def text(self):
        """The file."""
        lines = [
            "$MeshFormat",
            f"{self.version} 0 8",
            "$EndMeshFormat",
            "$PhysicalNames",
            str(len(self.groups)),
        ]
        lines += [f'{dimension} {tag} "{name}"' for name, (dimension, tag) in self.groups.items()]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.nodes))]
        lines += [f"{number} {x!r} {y!r} 0" for number, (x, y) in enumerate(self.nodes, start=1)]
        lines += ["$EndNodes", "$Elements", str(len(self.elements))]
        for number, (kind, group, nodes) in enumerate(self.elements, start=1):
            lines.append(f"{number} {kind} 2 {group} 1 " + " ".join(map(str, nodes)))
        return "\n".join([*lines, "$EndElements", ""])


def no_triangles(mesh):
    mesh.without(TRIANGLE)
    return mesh.text(), ["no triangles", "physical group"]


def triangle_without_group(mesh):
    kind, _, nodes = mesh.elements[-1]
    mesh.elements[-1] = (kind, 0, nodes)
    return mesh.text(), ["triangle 36 at (2.16667, 2.50000) is not in a physical surface"]


def no_such_group(mesh):
    mesh.groups = {"rock": (2, 3), "base": (1, 1), "fracture": (1, 2)}
    return mesh.text(), ["bottom"]


def two_groups_of_one_name(mesh):
    mesh.groups["bottom "] = (1, 4)
    mesh.add(LINE, 4, mesh.at(0, 3), mesh.at(1, 3))
    return mesh.text(), ["physical groups 1 and 4 have the same name 'bottom'"]


def quadrangles(mesh):
    mesh.without(TRIANGLE)
    mesh.add(QUADRANGLE, 3, mesh.at(0, 0), mesh.at(1, 0), mesh.at(1, 1), mesh.at(0, 1))
    return mesh.text(), ["wrong.msh", "1 elements of gmsh type 3 (quadrangles"]


def inverted(mesh):
    mesh.move((0.5, 0.5), (1.2, 0.5))
    return mesh.text(), ["triangle 2 at", "same side of their common edge", "inverted"]


def flat(mesh):
    mesh.move((0.5, 0.5), (1.0, 0.5))
    return mesh.text(), ["triangle 2 at (1.00000, 0.500000) has no area"]


def duplicate(mesh):
    mesh.elements.append(mesh.elements[-1])
    return mesh.text(), ["triangle 37 at", "is there already, as triangle 36 of group 'rock'"]


def hanging_node(mesh):
    """A square on the right whose left side has a node in the middle."""
    right = [mesh.add_node(4.0, 0.0), mesh.add_node(4.0, 1.0), mesh.add_node(3.0, 0.5)]
    mesh.add(TRIANGLE, 3, mesh.at(3, 0), right[0], right[2])
    mesh.add(TRIANGLE, 3, right[0], right[1], right[2])
    mesh.add(TRIANGLE, 3, right[1], mesh.at(3, 1), right[2])
    return mesh.text(), ["at (3.00000, 0.500000) hangs on the edge"]


def nodes_at_one_place(mesh):
    """A triangle on the right with nodes of its own."""
    mesh.add(TRIANGLE, 3, mesh.add_node(3.0, 0.0), mesh.add_node(4.0, 0.0), mesh.add_node(3.0, 1.0))
    return mesh.text(), ["at the same place (3.00000, 0.00000)", "at the same place (3.00000, 1.00000)"]


def three_triangles_on_an_edge(mesh):
    mesh.add(TRIANGLE, 3, mesh.at(1, 1), mesh.at(2, 1), mesh.add_node(1.4, 1.2))
    return mesh.text(), ["from (2.00000, 1.00000) to (1.00000, 1.00000) has 3 triangles"]


def fracture_not_embedded(mesh):
    mesh.add(LINE, 2, mesh.at(0, 1), mesh.at(1, 2))
    return mesh.text(), ["(0.00000, 1.00000) to (1.00000, 2.00000) of group 'fracture' is not an edge"]


def fracture_on_the_boundary(mesh):
    mesh.add(LINE, 2, mesh.at(0, 1), mesh.at(0, 2))
    return mesh.text(), ["of fracture group 'fracture'", "rock on both sides"]


def line_in_two_groups(mesh):
    mesh.add(LINE, 1, mesh.at(2, 1), mesh.at(1, 1))
    return mesh.text(), ["in group 'fracture' and in group 'bottom'"]


def cut_short(mesh):
    text = mesh.text()
    return text[: len(text) - 100], ["wrong.msh", "section $Elements cannot be read at line", "cut short"]


def a_word_for_a_number(mesh):
    words = ["wrong.msh", "section $Nodes cannot be read at line 12", "found 'nil'"]
    return mesh.text().replace("1 0.0 0.0 0", "1 0.0 nil 0"), words


def wrong_count(mesh):
    count = len(mesh.nodes)
    return mesh.text().replace(f"$Nodes\n{count}\n", f"$Nodes\n{count - 1}\n"), [
        "$EndNodes is expected at line"
    ]


def unknown_node(mesh):
    mesh.add(TRIANGLE, 3, 1, 2, 99)
    return mesh.text(), ["element 41 has node 99"]


def not_flat(mesh):
    return mesh.text().replace("1 0.0 0.0 0\n", "1 0.0 0.0 0.5\n"), ["must lie in a plane z = constant"]


def wrong_version(mesh):
    mesh.version = "4"
    return mesh.text(), ["wrong.msh", "gmsh format '4' is not read", "2.2 or 4.1"]


def not_a_mesh(_):
    return "Point(1) = {0, 0, 0, 0.1};\n", ["wrong.msh", "not a gmsh mesh"]


def empty_file(_):
    return "", ["wrong.msh", "not a gmsh mesh"]


CASES = {
    make.__name__: make
    for make in (
        no_triangles, triangle_without_group, no_such_group, two_groups_of_one_name, quadrangles, inverted, flat,
        duplicate, hanging_node, nodes_at_one_place, three_triangles_on_an_edge, fracture_not_embedded,
        fracture_on_the_boundary, line_in_two_groups, cut_short, a_word_for_a_number, wrong_count, unknown_node,
        not_flat, wrong_version, not_a_mesh, empty_file,
    )
}  # fmt: skip


def main():
    directory = Path(sys.argv[1])
    directory.mkdir(parents=True, exist_ok=True)
    for name, make in CASES.items():
        (directory / f"{name}.msh").write_text(make(Mesh())[0])


if __name__ == "__main__":
    main()
