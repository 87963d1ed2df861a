// Two blocks, one on the other, with a fracture between them, in gmsh's own language: gmsh two_blocks.geo opens it.
// gmsh -2 -format msh41 two_blocks.geo makes the mesh. manual/tutorial_4.md goes through it. Lengths are in metres.
h = 0.01;
Point(1) = {0, 0, 0, h};   Point(2) = {0.2, 0, 0, h};
Point(3) = {0, 0.1, 0, h}; Point(4) = {0.2, 0.1, 0, h};
Point(5) = {0, 0.2, 0, h}; Point(6) = {0.2, 0.2, 0, h};
Line(1) = {1, 2};
Line(2) = {3, 4}; // both blocks share it: the fracture
Line(3) = {5, 6};
Line(4) = {1, 3}; Line(5) = {2, 4};
Line(6) = {3, 5}; Line(7) = {4, 6};
Curve Loop(1) = {1, 5, -2, -4}; Plane Surface(1) = {1};
Curve Loop(2) = {2, 7, -3, -6}; Plane Surface(2) = {2};
Physical Surface("rock") = {1, 2};
Physical Curve("fracture") = {2};
Physical Curve("bottom") = {1};
Physical Curve("top") = {3};
Physical Curve("lower_sides") = {4, 5};
Physical Curve("upper_left") = {6};
